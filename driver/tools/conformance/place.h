// The board under test, and connections to it.
#pragma once

#include <chrono>
#include <filesystem>
#include <memory>
#include <string>

#include "raw_client.h"
#include "transport/launch.h"
#include "transport/uri.h"

namespace gicube::conformance {

using reference::RawClient;
using reference::RawFrame;

class Place {
 public:
  // An emu: URI starts a board that listens on a socket in a temporary folder, so that sessions can outlive
  // connections. Throws BadArgument (not emu:, unix: or tcp:), OpenFailed.
  Place(const std::string& uri, std::chrono::milliseconds silence);
  ~Place();
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  // The URI of the board for a driver.
  const std::string& uri() const { return uri_; }
  std::chrono::milliseconds silence() const { return silence_; }
  // A new connection. Reading from it throws if the board is silent for longer than `silence`.
  RawClient connect() const;
  // If the board's process has ended: how, and its last output.
  std::string last_words() const { return child_ ? child_->last_words() : std::string(); }

 private:
  std::string uri_;
  Uri parsed_;
  std::chrono::milliseconds silence_;
  std::filesystem::path folder_;  // of an emu: board's socket, or empty
  std::unique_ptr<ChildProcess> child_;
};

}  // namespace gicube::conformance
