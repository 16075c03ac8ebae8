// An empty registry of board processes (proto/gicube/registry.h) for this test and the programs that it starts.
#pragma once

#include <cstdlib>
#include <string>

#include "temporary_directory.h"

namespace gicube::reference {

class OwnRegistry {
 public:
  OwnRegistry() { ::setenv("XDG_RUNTIME_DIR", runtime_.path().c_str(), 1); }
  ~OwnRegistry() {
    if (former_.empty()) {
      ::unsetenv("XDG_RUNTIME_DIR");
    } else {
      ::setenv("XDG_RUNTIME_DIR", former_.c_str(), 1);
    }
  }
  OwnRegistry(const OwnRegistry&) = delete;
  OwnRegistry& operator=(const OwnRegistry&) = delete;

  // There once a board has run.
  std::string folder() const { return runtime_.file("gicube"); }

 private:
  static std::string value() {
    const char* text = std::getenv("XDG_RUNTIME_DIR");
    return text != nullptr ? text : "";
  }

  const std::string former_ = value();
  TemporaryDirectory runtime_;
};

}  // namespace gicube::reference
