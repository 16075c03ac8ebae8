// The driver's typed errors. The comment of each call lists its errors and the board's state after them.
#pragma once

#include <stdexcept>
#include <string>

#include "gicube/export.h"

namespace gicube {

// The parent of all errors that the driver throws.
struct GICUBE_API Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A value that the caller gave is wrong. Thrown before anything is sent: the board is untouched.
class GICUBE_API BadArgument : public Error {
 public:
  BadArgument(const std::string& field, const std::string& expected, const std::string& got)
      : Error(field + ": expected " + expected + ", got " + got), field_(field), expected_(expected), got_(got) {}

  const std::string& field() const { return field_; }
  const std::string& expected() const { return expected_; }
  const std::string& got() const { return got_; }

 private:
  std::string field_, expected_, got_;
};

// No board could be opened: the socket or the program of the URI does not exist, or does not answer.
struct GICUBE_API OpenFailed : Error {
  using Error::Error;
};

// The board has another owner; the message says who, and since when.
struct GICUBE_API BoardBusy : Error {
  using Error::Error;
};

// Driver and board speak different major versions.
struct GICUBE_API VersionMismatch : Error {
  using Error::Error;
};

// The board refused a request (its own words are the message); its state is as before the request.
struct GICUBE_API Rejected : Error {
  using Error::Error;
};

// The application's scattering routine gave an answer that no ray can follow (gicube/scattering.h).
struct GICUBE_API ScatteringFailed : Error {
  using Error::Error;
};

// The board's memory reported an error that it could not correct. Nothing has changed; the same call may be made again.
struct GICUBE_API MemoryFault : Error {
  using Error::Error;
};

// This board or fidelity level can't do what was asked; its state is as before the request.
struct GICUBE_API Unsupported : Error {
  using Error::Error;
};

enum class Loss {
  kClosed,     // the board's process ended, or the connection did
  kCorrupted,  // a frame was damaged, or one is missing
  kTimedOut,   // the watchdog expired; the call that it ended has thrown TimedOut
  kTakenOver,  // another client took the board by force
  // The board ended the session: it shuts down, was reset by management, or received a faulty frame. Or the driver
  // ended it, because its capture could not be written.
  kEnded,
};

// The connection to the board broke. Every waiting call throws this, and so do all later calls on the same Board until
// Board::reopen() succeeds, with the same session or on a new board.
class GICUBE_API DeviceLost : public Error {
 public:
  explicit DeviceLost(const std::string& text, Loss cause = Loss::kClosed) : Error(text), cause_(cause) {}

  Loss cause() const { return cause_; }

 private:
  Loss cause_;
};

// The simulated host waited until its deadline, a simulated time: Board::set_time_limit(), or the `deadline` of
// Pending::get() and RayTracer::receive(). The board continues.
struct GICUBE_API DeadlinePassed : Error {
  using Error::Error;
};

// The application has cancelled the call (Pending::cancel()). The work of the call is unfinished: a picture is
// undefined, the irradiance incomplete, a volume that was loading is lost. The Board takes the next call.
struct GICUBE_API Cancelled : Error {
  using Error::Error;
};

// OpenOptions::max_rays are under way. Nothing was sent: receive or poll before the next attempt.
struct GICUBE_API WouldBlock : Error {
  using Error::Error;
};

// No answer came within the wall-clock watchdog. The board may still be working. As after DeviceLost, the Board takes
// no calls until Board::reopen() succeeds.
struct GICUBE_API TimedOut : Error {
  using Error::Error;
};

}  // namespace gicube
