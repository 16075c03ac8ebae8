// The files of samples/apps/view/page, which CMake compiles into the program.
#pragma once

#include <span>
#include <string_view>

namespace gicube::samples::view {

struct PageFile {
  std::string_view name, type, content;
};
std::span<const PageFile> page_files();

}  // namespace gicube::samples::view
