// Facts of the format: ASTRA's page "3D geometries", cone_vec.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <sstream>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"

namespace gicube::samples {
namespace {

constexpr std::uintmax_t kMaxMib = 64;  // chosen

}  // namespace

ScanDescription read_astra(const std::filesystem::path& file, const StackFiles& projections, const PixelsGiven& given) {
  std::istringstream stream(read_text(file, "vectors of ASTRA", kMaxMib));
  std::vector<ViewPose> views;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    line.resize(std::min(line.find('#'), line.size()));
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream words(line);
    std::array<double, 12> numbers{};
    std::size_t count = 0;
    const std::string where = fmt::format("line {}", number);
    for (std::string word; words >> word; ++count) {
      const auto value = parse_number<double>(std::string_view(word).substr(word.starts_with('+') ? 1 : 0));
      expect(value && std::isfinite(*value), file, where, "numbers", '"' + word + '"');
      if (count < 12) numbers[count] = *value;
    }
    if (count == 0) continue;
    expect(count == 12, file, where, "twelve numbers", fmt::format("{}", count));
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
