#include "token_files.h"

#include <unistd.h>

#include <stdexcept>
#include <utility>

#include "gicube/access.h"
#include "gicube/registry.h"

namespace gicube::emu {

TokenFiles::TokenFiles(const std::vector<Endpoint>& endpoints, std::string token) : token_(std::move(token)) {
  for (const Endpoint& endpoint : endpoints) {
    if (endpoint.kind != EndpointKind::kTcp) continue;
    paths_.push_back(token_file(open_registry(), endpoint.address, endpoint.port));
    write_token(paths_.back(), token_);
  }
}

TokenFiles::~TokenFiles() {
  for (const std::string& path : paths_) {
    try {
      if (right_of(read_tokens(path), token_)) ::unlink(path.c_str());
    } catch (const std::runtime_error&) {  // the file was removed
    }
  }
}

}  // namespace gicube::emu
