#include "scene/formats/volume_library.h"

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "scene/common/checks.h"
#include "scene/common/temporary_file.h"
#include "scene/common/whole_file.h"
#include "scene/formats/data_stream.h"
#include "scene/formats/pictures/picture_library.h"
#include "scene/formats/readers.h"
#include "scene/formats/reading_child.h"

namespace gicube::scene {
namespace {

const VolumeLibrary& library_of(const std::string& name, const std::filesystem::path& file) {
  return *static_cast<const VolumeLibrary*>(plug_in(file, name));
}

// Whether the magic of DICOM follows a preamble of 128 bytes.
bool has_dicom_magic(const std::filesystem::path& file) {
  const std::string start = file_start(file, 132);
  return start.size() == 132 && start.ends_with("DICM");
}

}  // namespace

bool is_dicom(const std::filesystem::path& path) {
  std::error_code fault;
  if (!std::filesystem::is_directory(path, fault)) return has_dicom_magic(path);
  constexpr int kEnough = 64;  // chosen
  int balance = 0;             // of files that are DICOM and those that are pictures
  for (std::filesystem::recursive_directory_iterator entry(path, fault), end; !fault && entry != end;
       entry.increment(fault)) {
    std::error_code unreadable;
    if (!entry->is_regular_file(unreadable) || entry->path().filename().string().starts_with('.')) continue;
    const std::string extension = lower_case(entry->path().extension().string());
    if (std::ranges::count(kPictures, extension) > 0) {
      --balance;
    } else if (has_dicom_magic(entry->path())) {
      ++balance;
    }
    if (std::abs(balance) >= kEnough) break;
  }
  return balance > 0;
}

bool is_hdf5(const std::filesystem::path& file) { return file_start(file, 8) == "\x89HDF\r\n\x1a\n"; }

bool is_openvdb(const std::filesystem::path& file) { return file_start(file, 4) == " BDV"; }  // a little-endian "VDB "

Volume read_by(const std::string& library, const std::filesystem::path& file, const std::string& part) {
  const VolumeLibrary& reader = library_of(library, file);  // loaded here, once
  LibraryVolume read =
      library == "dicom" ? reader.read(file, part) : read_in_child(file, [&] { return reader.read(file, part); });
  for (const FileFault& each : read.warnings) warn(each.file, each.field, each.expected, each.got);
  if (read.fault) throw FileError(read.fault->file, read.fault->field, read.fault->expected, read.fault->got);
  read.layout.file = file;
  read.layout.big_endian = std::endian::native == std::endian::big;
  return to_volume(std::move(read.samples), read.layout);
}

void write_by(const std::string& library, const FloatVolume& volume, const std::filesystem::path& file) {
  // The library writes to a path directly, but an existing file must stay until the new one is complete.
  const TemporaryFile made;
  if (const auto fault = library_of(library, file).write(volume, made.path()))
    throw FileError(file, fault->field, fault->expected, fault->got);
  const std::vector<std::byte> bytes = read_data({made.path()}, file_bytes(made.path()));
  write_whole(file, [&bytes](WholeFile& out) {
    out.write({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  });
}

}  // namespace gicube::scene
