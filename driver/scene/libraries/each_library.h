// The common part of all libraries: converts exceptions of their functions to results.
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "scene/formats/volume_library.h"

namespace gicube::scene {

[[noreturn]] inline void fail(const std::filesystem::path& file, std::string field, std::string expected,
                              std::string got) {
  throw FileFault{file, std::move(field), std::move(expected), std::move(got)};
}

class EachLibrary final : public VolumeLibrary {
 public:
  using Read = LibraryVolume (*)(const std::filesystem::path& file, const std::string& part);
  using Write = void (*)(const FloatVolume& volume, const std::filesystem::path& file);

  // `name`: of the library, for messages. `start`: called once. `writes`: null for a format that is only read.
  EachLibrary(const char* name, void (*start)(), Read reads, Write writes = nullptr)
      : name_(name), read_(reads), write_(writes) {
    start();
  }
  LibraryVolume read(const std::filesystem::path& file, const std::string& part) const override {
    LibraryVolume out;
    try {
      return read_(file, part);
    } catch (const FileFault& fault) {
      out.fault = fault;
    } catch (const std::exception& error) {
      out.fault = {file, "file", std::string("one that ") + name_ + " can read", error.what()};
    }
    return out;
  }
  std::optional<FileFault> write(const FloatVolume& volume, const std::filesystem::path& file) const override {
    try {
      if (write_ == nullptr) fail(file, "format", "one that can be written", name_);
      write_(volume, file);
    } catch (const FileFault& fault) {
      return fault;
    } catch (const std::exception& error) {
      return FileFault{file, "file", "a place to write to", error.what()};
    }
    return std::nullopt;
  }

 private:
  const char* name_;
  Read read_;
  Write write_;
};

}  // namespace gicube::scene
