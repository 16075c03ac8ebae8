#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>

#include "cone_beam/scan/formats.h"
#include "scene/common/checks.h"
#include "scene/formats/data_stream.h"

namespace gicube::samples {
namespace {

using namespace std::string_view_literals;

// Files that users may mistake for a scan's description, by their first bytes. kind_of() uses the extension of others.
constexpr std::array kOthers{
    std::pair{"\x89HDF\r\n\x1a\n"sv,
              "an HDF5 file; a scan file names one of DXchange's layout as dxchange, with distances and pitch"},
    std::pair{"\x93NUMPY"sv, "an array of numpy: numpy.savetxt() writes vectors as text"},
    std::pair{"MATLAB 5.0"sv, "a MATLAB file"},
    std::pair{"II*\0"sv, "a TIFF picture: views belong to a scan's projections"},
    std::pair{"MM\0*"sv, "a TIFF picture: views belong to a scan's projections"},
    std::pair{"NRRD"sv, "an NRRD file: views belong to a scan's projections"},
    std::pair{"ObjectType"sv, "a MetaImage: views belong to a scan's projections"},
    std::pair{"Pf\n"sv, "a portable float map: views belong to a scan's projections"},
    std::pair{"\x89PNG"sv, "a PNG picture"},
    std::pair{"PK\x03\x04"sv, "a zip archive"},
    std::pair{"\x1f\x8b"sv, "a gzip file"},
    std::pair{"VMS.XI"sv, "a Varian .xim picture"},
};

// Whether the first line has twelve numbers.
bool is_vectors(const std::string& text) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::vector<std::string_view> words = words_of_vectors(line);
    const auto is_number = [](std::string_view word) { return signed_number(word).has_value(); };
    if (!words.empty()) return words.size() >= 3 && std::ranges::all_of(words, is_number);
  }
  return false;
}

}  // namespace

ScanKind kind_of(const std::filesystem::path& file) {
  constexpr std::size_t kStart = 4096;
  const std::string start = file_start(file, kStart);
  for (const auto& [magic, name] : kOthers) {
    expect(!start.starts_with(magic), file, "file",
           "a scan file, CTSimU's JSON, RTK's geometry, Nikon's .xtekct or ASTRA's vectors", name);
  }
  expect(start.substr(std::min<std::size_t>(128, start.size()), 4) != "DICM", file, "file", "a scan's description",
         "a DICOM file");
  const bool binary = std::ranges::any_of(start, [](unsigned char c) { return c < '\t' || (c > '\r' && c < ' '); });
  expect(!binary, file, "file", "a scan's description", "a binary file of an unknown kind");
  const std::size_t text = start.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  const std::string_view begin = text == std::string::npos ? "" : std::string_view(start).substr(text);
  const std::string extension = lower_case(file.extension().string());
  if (extension == ".json" || begin.starts_with('{')) return ScanKind::kCtsimu;
  if (extension == ".xml" || begin.starts_with("<?xml") || begin.starts_with("<RTK")) return ScanKind::kRtk;
  if (extension == ".xtekct" || begin.starts_with("[XTekCT]")) return ScanKind::kNikon;
  return is_vectors(std::string(begin)) ? ScanKind::kAstra : ScanKind::kScanFile;
}

}  // namespace gicube::samples
