#include "token_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <stdexcept>
#include <utility>

#include "gicube/access.h"
#include "gicube/registry.h"

namespace gicube::emu {

TokenFiles::TokenFiles(const std::vector<Endpoint>& endpoints, std::string token) : token_(std::move(token)) {
  const std::string folder = registry_folder();
  for (const Endpoint& endpoint : endpoints) {
    if (endpoint.kind != EndpointKind::kTcp) continue;
    ::mkdir(folder.c_str(), S_IRWXU);  // registry_fault() reports an error
    if (const std::string fault = registry_fault(folder); !fault.empty()) throw std::runtime_error(fault);
    paths_.push_back(token_file(folder, endpoint.address, endpoint.port));
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
