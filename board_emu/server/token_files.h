// Files through which this user's programs find this process's token (proto/gicube/access.h).
#pragma once

#include <string>
#include <vector>

#include "server/bus/endpoint.h"

namespace gicube::emu {

class TokenFiles {
 public:
  // Writes one file per TCP endpoint; creates the registry's folder if necessary. Throws std::runtime_error.
  TokenFiles(const std::vector<Endpoint>& endpoints, std::string token);
  // Removes the files that still contain this token.
  ~TokenFiles();

  TokenFiles(const TokenFiles&) = delete;
  TokenFiles& operator=(const TokenFiles&) = delete;

  const std::vector<std::string>& paths() const { return paths_; }

 private:
  const std::string token_;
  std::vector<std::string> paths_;
};

}  // namespace gicube::emu
