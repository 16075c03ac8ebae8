// Plays the host's side of a capture to a board and compares the answers.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "transport/fd.h"
#include "transport/tls.h"

namespace gicube::replay {

struct Report {
  std::uint64_t sent_frames = 0;
  std::uint64_t sent_bytes = 0;  // of payloads
  std::uint64_t compared = 0;    // answers and completions
  std::uint64_t missing = 0;     // answers of the captured board that this one did not give
  bool complete = false;         // the capture was ended properly
  // Both boards have the same configuration: then times and counters are compared too.
  bool same_machine = false;
  std::uint64_t differences = 0;
  std::string first_difference;  // in words; empty: none

  bool good() const { return differences == 0 && missing == 0; }
};

// How the board is connected, beyond a plain socket.
struct Access {
  std::string token;         // empty: none
  std::shared_ptr<Tls> tls;  // null: plain bytes
};

// Throws CaptureError, and std::runtime_error: the board refused the session, closed it, or does not answer.
Report play(const std::filesystem::path& capture, Fd board, std::chrono::milliseconds watchdog,
            const Access& access = {});

}  // namespace gicube::replay
