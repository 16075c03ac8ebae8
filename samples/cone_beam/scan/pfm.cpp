#include "cone_beam/scan/pfm.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <ostream>
#include <sstream>

#include "scene/formats/data_stream.h"
#include "scene/formats/stored_samples.h"
#include "scene/formats/whole_file.h"

namespace gicube::samples {

FloatMap read_pfm(const std::filesystem::path& file) {
  // Three fields of text, each followed by one white space; the samples begin behind the third.
  const std::string start = file_start(file, 256);
  std::istringstream header(start);
  std::string magic;
  long long width = 0, height = 0;
  double scale = 0;
  header >> magic >> width >> height >> scale;
  if (!header || magic != "Pf") {
    throw FileError(file, "header", "\"Pf\", width, height and scale", '"' + start.substr(0, start.find('\n')) + '"');
  }
  if (!(std::isfinite(scale) && scale != 0)) throw FileError(file, "scale", "a number but 0", fmt::format("{}", scale));
  const std::vector<std::int64_t> sizes{width, height, 1};
  StoredLayout layout;
  layout.file = file;
  layout.dims = checked_dims(file, "size", sizes);
  layout.type = StoredType::kFloat32;
  layout.big_endian = scale > 0;
  DataPlace place;
  place.file = file;
  place.offset = static_cast<std::uint64_t>(header.tellg()) + 1;
  place.nothing_after = true;
  const Volume volume = to_volume(read_data(place, checked_bytes(layout)), layout);
  FloatMap map{layout.dims[0], layout.dims[1], {}};
  map.values.resize(volume.samples.size() / sizeof(float));
  std::memcpy(map.values.data(), volume.samples.data(), volume.samples.size());
  return map;
}

void write_pfm(std::span<const float> values, int width, int height, const std::filesystem::path& file) {
  static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");
  write_whole(file, [&](std::ostream& stream) {
    stream << "Pf\n" << width << ' ' << height << "\n-1\n";
    stream.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
  });
}

}  // namespace gicube::samples
