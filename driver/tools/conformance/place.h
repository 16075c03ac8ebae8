// Where the tested board is, and how it is reached.
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
  // emu: starts a board that serves a socket of a folder of its own, so that sessions can outlive connections.
  // Throws BadArgument (not emu:, unix: or tcp:), OpenFailed.
  Place(const std::string& uri, std::chrono::milliseconds silence);
  ~Place();
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  // The URI under which a driver finds the board.
  const std::string& uri() const { return uri_; }
  std::chrono::milliseconds silence() const { return silence_; }
  // A new connection, which reports `silence` as a failure.
  RawClient connect() const;
  // Words for the report if the board's process has ended.
  std::string last_words() const { return child_ ? child_->last_words() : std::string(); }

 private:
  std::string uri_;
  Uri parsed_;
  std::chrono::milliseconds silence_;
  std::filesystem::path folder_;  // empty: none of ours
  std::unique_ptr<ChildProcess> child_;
};

}  // namespace gicube::conformance
