// The management plane: the gRPC service of management.proto with the standard health service and reflection.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "gicube/access.h"
#include "server/audit.h"
#include "server/bus/board_slot.h"
#include "server/bus/endpoint.h"

namespace gicube::emu {

struct ManagementOptions {
  Endpoint endpoint;
  // PEM files, and that of tokens (proto/gicube/access.h). Needed where other machines can reach the endpoint.
  std::string certificate_file, key_file, token_file;
  std::vector<AccessToken> tokens{};  // beside those of the file: one of all these is asked of each caller over TCP
  Audit* audit = nullptr;             // must outlive the plane; null: there is none
  std::string trace_folder{};         // where SetTrace may create files; empty: nowhere
};

// Why these options are refused, by flag; empty if they are good. Reads no file.
std::vector<Diagnostic> check(const ManagementOptions& options);

// The token of a header that is "Bearer " and a token; else nothing, which is nobody's token.
std::string_view bearer_token(std::string_view authorization);

// The file that SetTrace is asked to write: one in `folder`, by its name or its whole path. Throws std::invalid_argument.
std::string trace_path(const std::string& folder, const std::string& file);

class Management {
 public:
  // Serves the boards, which must outlive this, on gRPC's threads. Throws std::runtime_error that names what is at fault.
  Management(const ManagementOptions& options, std::vector<BoardSlot*> boards);
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
