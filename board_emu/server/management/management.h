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
  // PEM files, and the token file (proto/gicube/access.h). Required if other machines can reach the endpoint.
  std::string certificate_file, key_file, token_file;
  std::vector<AccessToken> tokens{};  // in addition to the file's; each caller over TCP needs one of all these
  Audit* audit = nullptr;             // must outlive the management plane; may be null
  std::string trace_folder{};         // folder in which SetTrace may create files; empty: none
};

// Checks the options without reading files. Returns the errors by flag.
std::vector<Diagnostic> check(const ManagementOptions& options);

// Returns the token of a header "Bearer TOKEN", otherwise an empty text, which is never a valid token.
std::string_view bearer_token(std::string_view authorization);

// Returns the path of the file for SetTrace, which must be in `folder`; `file` is a name or full path. Throws
// std::invalid_argument.
std::string trace_path(const std::string& folder, const std::string& file);

class Management {
 public:
  // Serves the boards, which must outlive this object, on gRPC's threads. Throws std::runtime_error with the reason.
  Management(const ManagementOptions& options, std::vector<BoardSlot*> boards);
  ~Management();

  Management(const Management&) = delete;
  Management& operator=(const Management&) = delete;

  // The endpoint with the actual port.
  const Endpoint& endpoint() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace gicube::emu
