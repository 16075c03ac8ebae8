#include "scene/geometry/mesh_file.h"

#include <algorithm>
#include <fstream>
#include <string>

#include "scene/program/input_error.h"

namespace gicube::samples {
namespace {

std::string read_all(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw FileError(path, "file", "a mesh", "no such file");
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error || bytes > kMaxMeshBytes) {
    throw FileError(path, "size", "at most " + std::to_string(kMaxMeshBytes) + " bytes", std::to_string(bytes));
  }
  std::string text(static_cast<std::size_t>(bytes), '\0');
  std::ifstream stream(path, std::ios::binary);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream) throw FileError(path, "file", "one that can be read", "an error");
  return text;
}

}  // namespace

Mesh read_mesh(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension != ".obj" && extension != ".ply") {
    throw FileError(path, "name", "an ending .obj or .ply", in_quotes(extension));
  }
  const std::string text = read_all(path);
  return extension == ".obj" ? parse_obj(text, path) : parse_ply(text, path);
}

}  // namespace gicube::samples
