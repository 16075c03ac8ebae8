// Source of the format: ASTRA's page "3D geometries", cone_vec.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"

namespace gicube::samples {
namespace {

constexpr std::uintmax_t kMaxMib = 64;  // chosen

}  // namespace

std::optional<double> signed_number(std::string_view word) {
  return parse_number<double>(word.substr(word.starts_with('+') ? 1 : 0));
}

std::vector<std::string_view> words_of_vectors(std::string& line) {
  line.resize(std::min(line.find('#'), line.size()));
  std::ranges::replace(line, ',', ' ');
  return words_of(line);
}

ScanDescription read_astra(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given) {
  std::istringstream stream(read_text(file, "vectors of ASTRA", kMaxMib));
  std::vector<ViewPose> views;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::vector<double> numbers;
    const std::string where = fmt::format("line {}", number);
    for (const std::string_view word : words_of_vectors(line)) {
      const auto value = signed_number(word);
      expect(value && std::isfinite(*value), file, where, "numbers", fmt::format("\"{}\"", word));
      numbers.push_back(*value);
    }
    if (numbers.empty()) continue;
    expect(numbers.size() == 12, file, where, "twelve numbers", fmt::format("{}", numbers.size()));
    const auto vector = [&numbers](std::size_t i) { return Vec3{numbers[i], numbers[i + 1], numbers[i + 2]}; };
    views.push_back({vector(0), vector(3), vector(6), vector(9)});
    check_view(views.back(), file, where);
  }
  expect(views.size() >= 2, file, "views", "at least 2", fmt::format("{}", views.size()));
  return scan_of(std::move(views), pixels_of(projections, given, file), file, projections);
}

void write_astra(const ConeGeometry& geometry, const std::filesystem::path& file) {
  std::string text = "# source, detector's middle, step to the next column, step to the next row: x y z each\n";
  for (std::size_t view = 0; view < geometry.angles.size(); ++view) {
    const ViewPose at = pose(geometry, view);
    for (const Vec3 v : {at.source, at.centre, at.u, at.v}) {
      text += fmt::format("{:.15g} {:.15g} {:.15g} ", v.x + 0.0, v.y + 0.0, v.z + 0.0);
    }
    text.back() = '\n';
  }
  write_whole(file, text);
}

}  // namespace gicube::samples
