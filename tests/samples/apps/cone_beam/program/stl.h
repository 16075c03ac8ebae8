// Triangles of a binary STL file.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "gicube/scene/mesh.h"
#include "scene/names.h"

namespace gicube::samples {

inline Mesh read_stl(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  constexpr std::size_t kHeader = 84, kTriangle = 50, kNormal = 12;
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, 4);
  if (count == 0 || bytes.size() != kHeader + kTriangle * count)
    throw std::runtime_error(file.string() + ": no binary STL");
  Mesh mesh;
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<float, 9> corners{};
    std::memcpy(corners.data(), bytes.data() + kHeader + kTriangle * i + kNormal, sizeof corners);
    for (std::size_t k = 0; k < 9; k += 3) {
      mesh.points.push_back(
          {static_cast<double>(corners[k]), static_cast<double>(corners[k + 1]), static_cast<double>(corners[k + 2])});
    }
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

}  // namespace gicube::samples
