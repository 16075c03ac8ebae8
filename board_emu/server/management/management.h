// The management plane: the gRPC service of management.proto with the standard health service and reflection.
// gRPC's own headers stay in management.cpp.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "server/bus/board_slot.h"
#include "server/bus/endpoint.h"

namespace gicube::emu {

struct ManagementOptions {
  Endpoint endpoint;
  // PEM files and the token's file, which only its owner may read. Needed where other machines can reach the endpoint;
  // used wherever they are given.
  std::string certificate_file;
  std::string key_file;
  std::string token_file;
};

// Why these options are refused, by flag; empty if they are good. Reads no file.
std::vector<Diagnostic> check(const ManagementOptions& options);

// The secret of remote management: the file's content without its line end. Throws std::runtime_error if the file can't be
// read, if others than its owner may, or if the token is too short.
inline constexpr std::size_t kMinTokenBytes = 16;  // chosen: 64 bits and more, if its digits are random
std::string read_token(const std::string& path);
// True if the header is "Bearer " and the token; takes the same time wherever they differ.
bool is_authorized(std::string_view authorization, std::string_view token);

class Management {
 public:
  // Serves the boards, each of which must outlive this, on gRPC's threads. Throws std::runtime_error that names the file
  // or the endpoint at fault, or carries what check() found.
  Management(const ManagementOptions& options, std::vector<BoardSlot*> boards);
  // Ends every call and closes the endpoint.
  ~Management();

  Management(const Management&) = delete;
  Management& operator=(const Management&) = delete;

  // With the port that it got.
  const Endpoint& endpoint() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gicube::emu
