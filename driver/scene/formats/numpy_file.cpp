// numpy's .npy, and .npz, a ZIP archive of them (numpy.lib.format).
#include <fmt/format.h>
#include <minizip/unzip.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <memory>

#include "scene/common/checks.h"
#include "scene/formats/readers.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kMaxHeaderBytes = 65536;  // chosen
constexpr std::string_view kMagic = "\x93NUMPY";

// The value of a key in a Python dictionary as numpy writes it: the text up to a comma outside brackets.
std::string_view value_of(std::string_view dictionary, std::string_view key) {
  const std::size_t at = dictionary.find("'" + std::string(key) + "':");
  if (at == std::string_view::npos) return {};
  const std::string_view rest = dictionary.substr(at + key.size() + 3);
  int depth = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    if (rest[i] == '(' || rest[i] == '[') ++depth;
    if (rest[i] == ')' || rest[i] == ']') --depth;
    if ((rest[i] == ',' && depth == 0) || rest[i] == '}') return trimmed(rest.substr(0, i));
  }
  return {};
}

// `descr`: with its quotes, as '<i2'.
StoredType type_of(const std::filesystem::path& file, std::string_view descr) {
  const std::string_view kind = descr.size() == 5 ? descr.substr(2, 1) : "";
  const auto type = kind == "b"    ? std::optional(StoredType::kUint8)
                    : kind.empty() ? std::nullopt
                                   : type_named(fmt::format("{}{}",
                                                            kind == "i"   ? "int"
                                                            : kind == "u" ? "uint"
                                                                          : "float",
                                                            8 * (descr[3] - '0')));
  if (!type || std::string_view("biuf").find(kind) == std::string_view::npos)
    throw FileError(file, "descr", "a bool, or a number of at most 64 bits that is no half float", std::string(descr));
  return *type;
}

// `read` fills its bytes from the start of the .npy file and returns their number. The result has no offset and
// compression of the place.
StoredFile find_array(const std::filesystem::path& file, const std::function<std::size_t(std::span<std::byte>)>& read,
                      const std::string& part) {
  std::array<unsigned char, 12> start{};
  if (read(std::as_writable_bytes(std::span(start).first(10))) < 10 ||
      std::memcmp(start.data(), kMagic.data(), kMagic.size()) != 0)
    throw FileError(file, "magic", "\\x93NUMPY", "another beginning, or a shorter file");
  const bool is_long = start[6] >= 2;
  std::size_t begin = 10, bytes = start[8] + 256U * start[9];
  if (is_long) {
    read(std::as_writable_bytes(std::span(start).subspan(10)));
    bytes += 65536U * start[10] + 16777216U * start[11];
    begin = 12;
  }
  std::string header(std::min(bytes, kMaxHeaderBytes), '\0');
  if (bytes > kMaxHeaderBytes || read(std::as_writable_bytes(std::span(header))) < bytes)
    throw FileError(file, "header", fmt::format("at most {} bytes", kMaxHeaderBytes),
                    fmt::format("{}, or a shorter file", bytes));
  const std::string_view descr = value_of(header, "descr"), order = value_of(header, "fortran_order");
  if (order != "True" && order != "False") throw FileError(file, "fortran_order", "True or False", in_quotes(order));
  std::string shape(value_of(header, "shape"));
  std::ranges::replace_if(
      shape, [](char c) { return c == '(' || c == ')' || c == ','; }, ' ');
  std::vector<std::int64_t> sizes;
  for (const std::string_view word : words_of(shape)) {
    const auto size = parse_number<std::int64_t>(word);
    if (!size) throw FileError(file, "shape", "whole numbers", in_quotes(value_of(header, "shape")));
    sizes.push_back(*size);
  }
  if (order == "False") std::ranges::reverse(sizes);  // the last index runs fastest
  StoredFile found;
  found.layout.file = file;
  found.layout.dims = checked_dims(file, "shape", sizes);
  found.layout.type = type_of(file, descr);
  found.layout.big_endian = descr[1] == '>';
  const std::size_t chosen = chosen_part(file, "volume", volumes_in(file, "shape", sizes), part);
  found.place.file = file;
  found.place.skip = begin + bytes + chosen * std::uint64_t{checked_bytes(found.layout)};
  return found;
}

struct ZipClose {
  void operator()(void* zip) const { unzClose(zip); }
};

}  // namespace

bool is_numpy(const std::filesystem::path& file) { return file_start(file, kMagic.size()) == kMagic; }

StoredFile find_numpy(const std::filesystem::path& file, const std::string& part) {
  DataStream stream(file, 0, Compression::kNone);
  return find_array(
      file, [&](std::span<std::byte> bytes) { return stream.read(bytes); }, part);
}

StoredFile find_numpy_archive(const std::filesystem::path& file, const std::string& part) {
  file_bytes(file);  // throws for a missing file
  const std::unique_ptr<void, ZipClose> zip(unzOpen64(file.c_str()));
  if (!zip) throw FileError(file, "archive", "a ZIP archive", "none, or one without its end");
  std::vector<std::string> names;
  for (int status = unzGoToFirstFile(zip.get()); status == UNZ_OK && names.size() < kMaxParts;
       status = unzGoToNextFile(zip.get())) {
    std::array<char, 256> name{};
    unz_file_info64 info{};
    if (unzGetCurrentFileInfo64(zip.get(), &info, name.data(), name.size() - 1, nullptr, 0, nullptr, 0) != UNZ_OK)
      break;
    const std::string_view text(name.data());
    if (text.ends_with(".npy")) names.emplace_back(text.substr(0, text.size() - 4));
  }
  const bool several = names.size() != 1;
  if (names.empty() || (several && std::ranges::find(names, part) == names.end())) {
    throw FileError(file, "part", fmt::format("one of the arrays {}", fmt::join(names, ", ")),
                    names.empty() ? "no array" : in_quotes(part));
  }
  const std::string name = (several ? part : names.front()) + ".npy";
  int method = 0, level = 0;
  if (unzLocateFile(zip.get(), name.c_str(), 1) != UNZ_OK ||
      unzOpenCurrentFile2(zip.get(), &method, &level, 0) != UNZ_OK)
    throw FileError(file, name, "an array in the archive", "a damaged entry");
  const std::uint64_t begin = unzGetCurrentFileZStreamPos64(zip.get());  // before minizip has read any of it
  StoredFile found = find_array(
      file,
      [&](std::span<std::byte> bytes) {
        const int came = unzReadCurrentFile(zip.get(), bytes.data(), static_cast<unsigned>(bytes.size()));
        return came > 0 ? static_cast<std::size_t>(came) : 0;
      },
      several || part == names.front() ? std::string() : part);
  found.place.offset = begin;
  found.place.compression = method == 0 ? Compression::kNone : Compression::kDeflate;
  return found;
}

}  // namespace gicube::scene
