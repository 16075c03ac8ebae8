#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <span>
#include <sstream>

#include "cone_beam/scan/description.h"
#include "gicube/scene/volume_file.h"
#include "scene/common/checks.h"
#include "scene/common/whole_file.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/pictures/picture_library.h"
#include "scene/formats/readers.h"
#include "scene/formats/stored_samples.h"

namespace gicube::samples {
namespace {

Stack stack_of(const Volume& volume) {
  return {volume.dims[0], volume.dims[1], values_of(volume), volume.type != SampleType::kFloat32};
}

// Reads as many views as the file has; one from a compressed file, whose size does not give the number.
Stack read_raw(const std::filesystem::path& file, RawLayout layout) {
  const auto pixels = static_cast<std::uint64_t>(layout.dims[0]) * static_cast<std::uint64_t>(layout.dims[1]);
  const std::uint64_t view = pixels * bytes_per_sample(layout.type);
  const std::uint64_t bytes = file_bytes(file), data = bytes - std::min(bytes, layout.skip_bytes);
  if (layout.dims[2] == 0) {
    expect(lower_case(file.extension().string()) != ".gz", file, "views",
           "the number of views of a compressed raw file", "none");
    expect(view != 0 && data != 0 && data % view == 0 && data / view <= kMaxFileDim, file, "size",
           fmt::format("{} bytes and 1 to {} views of {} x {} pixels ({} bytes each)", layout.skip_bytes, kMaxFileDim,
                       layout.dims[0], layout.dims[1], view),
           fmt::format("{} bytes", bytes));
    layout.dims[2] = static_cast<int>(data / view);
  }
  return stack_of(read_volume(file, layout));
}

Stack read_one(const std::filesystem::path& file, const StackFiles& files) {
  const std::string extension = lower_case(file.extension().string());
  const auto is_one_of = [&](std::initializer_list<const char*> known) {
    return std::ranges::find(known, extension) != known.end();
  };
  if (extension == ".pfm") return read_pfm(file);
  if (is_one_of({".tif", ".tiff", ".png", ".bmp", ".pgm", ".exr"})) return stack_of(read_pages(file));
  std::error_code error;
  const bool headed = std::filesystem::is_directory(file, error) ||
                      is_one_of({".nrrd", ".nhdr", ".mhd", ".mha", ".nii"}) ||
                      file.filename().string().ends_with(".nii.gz");
  if (files.raw && !headed) return read_raw(file, *files.raw);
  VolumeSource source;
  source.file = file;
  source.spacing = Vec3{1, 1, 1};  // the scan has its own
  source.allow_outside = files.allow_outside;
  source.part = files.part;
  source.as_stored = true;  // columns, rows and views are no axes of space
  return stack_of(read_volume(source));
}

void check_finite(const std::filesystem::path& file, const Stack& stack) {
  const auto bad = std::ranges::find_if(stack.values, [](float value) { return !std::isfinite(value); });
  if (bad == stack.values.end()) return;
  const auto at = static_cast<std::size_t>(bad - stack.values.begin());
  throw FileError(file, fmt::format("view {}, pixel {}", at / stack.view_size(), at % stack.view_size()),
                  "a finite value", fmt::format("{}", *bad));
}

// NAME_0007.EXT for the seventh of NAME.EXT.
std::filesystem::path numbered(const std::filesystem::path& path, std::size_t number) {
  return std::filesystem::path(path).replace_filename(
      fmt::format("{}_{:04}{}", path.stem().string(), number, path.extension().string()));
}

void write_tiff(std::span<const float> values, const Stack& stack, const std::filesystem::path& path,
                WholeFiles& files) {
  const PictureToWrite picture{"tiff", stack.columns, stack.rows,
                               1,      values.data(), {{"compression", "none"}}};  // which every reader of stacks knows
  const auto bytes = encoded_picture(path, picture);
  files.write(path, [&bytes](WholeFile& file) { file.write(std::span(bytes)); });
}

// Little-endian, scale 1.
void write_pfm(std::span<const float> values, const Stack& stack, const std::filesystem::path& path,
               WholeFiles& files) {
  static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");
  files.write(path, [&](WholeFile& file) {
    file.write(fmt::format("Pf\n{} {}\n-1\n", stack.columns, stack.rows));
    file.write(values);
  });
}

}  // namespace

Stack read_pfm(const std::filesystem::path& file) {
  // Three fields of text, each followed by one white space; the samples follow the third.
  const std::string start = file_start(file, 256);
  std::istringstream header(start);
  std::string magic;
  std::int64_t width = 0, height = 0;
  double scale = 0;
  header >> magic >> width >> height >> scale;
  expect(header && magic == "Pf", file, "header", "\"Pf\", width, height and scale",
         '"' + start.substr(0, start.find('\n')) + '"');
  expect(std::isfinite(scale) && scale != 0, file, "scale", "a number but 0", fmt::format("{}", scale));
  const std::vector<std::int64_t> sizes{width, height, 1};
  const StoredLayout layout{
      .file = file, .dims = checked_dims(file, "size", sizes), .type = StoredType::kFloat32, .big_endian = scale > 0};
  const DataPlace place{.file = file, .offset = static_cast<std::uint64_t>(header.tellg()) + 1, .nothing_after = true};
  return stack_of(to_volume(read_data(place, checked_bytes(layout)), layout));
}

Stack read_stack(const StackFiles& files) {
  Stack out;
  for (const std::filesystem::path& file : files.files) {
    Stack stack = read_one(file, files);
    check_finite(file, stack);
    if (out.values.empty()) {
      out = std::move(stack);
      out.values.reserve(out.values.size() * files.files.size());  // a file a view, most often
      continue;
    }
    expect(stack.columns == out.columns && stack.rows == out.rows, file, "size",
           fmt::format("{} x {} as in the first file", out.columns, out.rows),
           fmt::format("{} x {}", stack.columns, stack.rows));
    out.values.insert(out.values.end(), stack.values.begin(), stack.values.end());
    out.counts = out.counts && stack.counts;
  }
  return out;
}

std::vector<std::filesystem::path> stack_files(const std::filesystem::path& path, std::size_t views) {
  const std::string extension = lower_case(path.extension().string());
  if (extension != ".tif" && extension != ".tiff" && extension != ".pfm") return {path};
  std::vector<std::filesystem::path> names;
  for (std::size_t view = 0; view < views; ++view) names.push_back(numbered(path, view));
  return names;
}

std::vector<std::filesystem::path> write_stack(const Stack& stack, const std::filesystem::path& path,
                                               const Provenance& provenance) {
  const std::string extension = lower_case(path.extension().string());
  const bool tiff = extension == ".tif" || extension == ".tiff";
  if (extension == ".raw") {
    write_whole(path, [&stack](WholeFile& file) { file.write(std::span(stack.values)); });
    return {path};
  }
  if (!tiff && extension != ".pfm") {
    write_volume({{stack.columns, stack.rows, static_cast<int>(stack.views())}, {1, 1, 1}, {}, stack.values}, path,
                 provenance);
    return {path};
  }
  const std::vector<std::filesystem::path> names = stack_files(path, stack.views());
  WholeFiles files;
  for (std::size_t view = 0; view < stack.views(); ++view) {
    const auto values = std::span(stack.values).subspan(view * stack.view_size(), stack.view_size());
    (tiff ? write_tiff : write_pfm)(values, stack, names[view], files);
  }
  files.commit();
  return names;
}

}  // namespace gicube::samples
