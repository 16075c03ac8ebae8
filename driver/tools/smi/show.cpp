#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "options.h"

// Reads a file's provenance (gicube/scene/provenance.h) itself, since it needs nothing else of gicube-scene.
namespace gicube::smi {
namespace {

using Entries = std::vector<std::pair<std::string, std::string>>;

constexpr std::string_view kPrefix = "gicube.";
constexpr std::size_t kMaxHeader = std::size_t{1} << 20;  // chosen: bytes; headers of our files take a few hundred
constexpr std::size_t kMaxJson = std::size_t{64} << 20;   // chosen

// The first bytes of the file, unpacked if it is gzipped. Throws UsageError, also for a pipe, which may never deliver
// any.
std::string start_of(const std::string& path, std::size_t max_bytes) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    throw UsageError("show: expected a file, got a folder, a pipe or a device, " + path);
  }
  const std::unique_ptr<gzFile_s, decltype(&gzclose)> file(gzopen(path.c_str(), "rb"), &gzclose);
  if (!file) throw UsageError("show: expected a file that can be read, got " + path);
  std::string bytes, chunk(65536, '\0');
  while (bytes.size() < max_bytes) {
    const int count = gzread(file.get(), chunk.data(), static_cast<unsigned>(chunk.size()));
    if (count < 0) throw UsageError("show: expected a file that can be read, got a damaged one, " + path);
    if (count == 0) break;
    bytes.append(chunk, 0, static_cast<std::size_t>(count));
  }
  return bytes;
}

// Takes bytes off the front; missing bytes are zero or empty.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes) : rest_(bytes) {}

  bool ended() const { return rest_.empty(); }
  std::string_view take(std::size_t count) {
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(taken.size());
    return taken;
  }
  std::string_view take_to(char end) {
    const std::string_view taken = take(rest_.find(end));
    take(1);
    return taken;
  }
  std::uint32_t little() {
    std::uint32_t value = 0;
    int shift = 0;
    for (const char c : take(4)) value |= std::uint32_t{static_cast<unsigned char>(c)} << shift, shift += 8;
    return value;
  }
  std::uint32_t big() {
    std::uint32_t value = 0;
    for (const char c : take(4)) value = value << 8 | static_cast<unsigned char>(c);
    return value;
  }

 private:
  std::string_view rest_;
};

void add(Entries& entries, std::string_view key, std::string_view value) {
  if (!key.starts_with(kPrefix)) return;
  entries.emplace_back(key.substr(kPrefix.size()), value);
}

// Chunks of length, type, data, checksum; a text begins with its key.
Entries of_png(std::string_view bytes) {
  Entries entries;
  Cursor file(bytes);
  file.take(8);
  while (!file.ended()) {
    const std::uint32_t length = file.big();
    const std::string_view type = file.take(4), chunk = file.take(length);
    file.take(4);
    if (chunk.size() < length) break;  // the file ends within it
    Cursor data(chunk);
    const std::string_view key = data.take_to('\0');
    if (type == "tEXt") add(entries, key, data.take(length));
  }
  return entries;
}

// Attributes of name, type, size, value, up to an empty name.
Entries of_exr(std::string_view bytes) {
  Entries entries;
  Cursor file(bytes);
  file.take(8);
  while (!file.ended()) {
    const std::string_view name = file.take_to('\0'), type = file.take_to('\0');
    if (name.empty()) break;
    const std::uint32_t size = file.little();
    const std::string_view value = file.take(size);
    if (value.size() < size) break;  // the file ends within it
    if (type == "string") add(entries, name, value);
  }
  return entries;
}

// Lines up to an empty one; those of ours are "key:=value", whose backslashes and line ends are escaped.
Entries of_nrrd(std::string_view bytes) {
  Entries entries;
  Cursor file(bytes);
  while (!file.ended()) {
    const std::string_view line = file.take_to('\n');
    if (line.empty()) break;
    const std::size_t middle = line.find(":=");
    if (middle == std::string_view::npos) continue;
    std::string value;
    bool escaped = false;
    for (const char c : line.substr(middle + 2)) {
      if (!escaped && c == '\\') {
        escaped = true;
        continue;
      }
      value += escaped && c == 'n' ? '\n' : c;
      escaped = false;
    }
    add(entries, line.substr(0, middle), value);
  }
  return entries;
}

// NIfTI-1: 348 bytes, 4 that state whether extensions follow, then extensions with size and code (6: comment).
Entries of_nifti(std::string_view bytes) {
  Entries entries;
  Cursor file(bytes);
  file.take(348);
  const std::string_view extended = file.take(4);
  if (extended.empty() || extended[0] == '\0') return entries;
  const std::uint32_t size = file.little(), code = file.little();
  if (code != 6 || size < 8) return entries;
  Cursor text(file.take(size - 8));
  while (!text.ended()) {
    Cursor line(text.take_to('\n'));
    const std::string_view key = line.take_to('=');
    add(entries, key, line.take(size));
  }
  return entries;
}

Entries of_json(const std::string& text) {
  Entries entries;
  const auto json = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!json.is_object() || !json.contains("provenance")) return entries;
  for (const auto& [key, value] : json["provenance"].items()) {
    if (value.is_string()) entries.emplace_back(key, value.get<std::string>());
  }
  return entries;
}

// Sorts entries in the order of provenance.h; EXR sorts its attributes by name.
void put_in_order(Entries& entries) {
  constexpr std::array<std::string_view, 6> kOrder{"program",     "version",  "command",
                                                   "config_hash", "fidelity", "scene_hash"};
  std::ranges::stable_sort(entries, {},
                           [&](const auto& entry) { return std::ranges::find(kOrder, entry.first) - kOrder.begin(); });
}

Entries entries_of(const std::string& path) {
  const std::string start = start_of(path, kMaxHeader);
  if (start.starts_with("\x89PNG")) return of_png(start);
  if (start.starts_with("\x76\x2f\x31\x01")) return of_exr(start);
  if (start.starts_with("NRRD000")) return of_nrrd(start);
  if (start.size() >= 348 && start.substr(344, 3) == "n+1") return of_nifti(start);
  if (start.starts_with("{")) return of_json(start_of(path, kMaxJson));
  throw UsageError("show: expected a PNG, EXR, NRRD, NIfTI or JSON file, got " + path);
}

}  // namespace

int show(const Options& options) {
  Entries entries = entries_of(options.shown_file);
  put_in_order(entries);
  if (entries.empty()) {
    fmt::print(stderr, "gicube-smi: {} has no provenance\n", options.shown_file);
    return 1;
  }
  if (options.json) {
    nlohmann::ordered_json json;
    for (const auto& [key, value] : entries) json[key] = value;
    fmt::print("{}\n", json.dump(2));
    return 0;
  }
  for (const auto& [key, value] : entries) fmt::print("{:<12} {}\n", key, value);
  return 0;
}

}  // namespace gicube::smi
