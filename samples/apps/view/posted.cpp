#include "view/posted.h"

#include <fmt/format.h>

#include <utility>

#include "gicube/scene/error.h"

namespace gicube::samples::view {
namespace {

namespace fs = std::filesystem;

// Bytes of a file or of all files in a folder; 0: there is none.
std::uint64_t bytes_at(const fs::path& path) {
  std::error_code none;
  const std::uint64_t bytes = fs::is_regular_file(path, none) ? fs::file_size(path, none) : 0;
  if (none) return 0;
  std::uint64_t sum = bytes;
  for (const auto& entry : fs::directory_iterator(path, none)) sum += bytes_at(entry.path());
  return sum;
}

bool moved(const fs::path& from, const fs::path& to) {
  std::error_code none;
  fs::rename(from, to, none);
  return !none;
}

}  // namespace

PostedFiles::PostedFiles(fs::path folder) : folder_(std::move(folder)) {
  for (const fs::path& each : {waiting(""), aside("")}) fs::create_directories(each);
}

void PostedFiles::remove(const fs::path& file) {
  bytes_ -= bytes_at(file);
  std::error_code ignored;
  fs::remove_all(file, ignored);
}

PostedFiles::Part::Part(PostedFiles& all, const std::string& name)
    : all_(all),
      path_(all.waiting(fmt::format(".part-{}", ++all.last_part_))),
      target_(all.waiting(name)),
      replaced_(bytes_at(target_) + bytes_at(all.folder_ / name)),
      stream_(path_, std::ios::binary | std::ios::trunc) {}

PostedFiles::Part::~Part() {
  if (kept_) return;
  std::error_code ignored;
  fs::remove(path_, ignored);
  all_.bytes_ -= taken_;
}

bool PostedFiles::Part::take(std::uint64_t bytes) {
  if (bytes > kMaxFileBytes) return false;
  if ((all_.bytes_ += bytes) > kMaxFileBytes + replaced_) {
    all_.bytes_ -= bytes;
    return false;
  }
  taken_ += bytes;
  return true;
}

bool PostedFiles::Part::keep() {
  stream_.close();
  if (!stream_) return false;
  const std::lock_guard lock(all_.mutex_);
  all_.remove(target_);
  kept_ = moved(path_, target_);
  return kept_;
}

PostedFiles::Opening::Opening(PostedFiles& all, const std::vector<std::string>& names) : all_(all), names_(names) {
  const std::lock_guard lock(all_.mutex_);
  for (const std::string& name : names) {
    if (!fs::exists(all_.waiting(name)) && !fs::exists(all_.folder_ / name))
      throw InputError(name, "a posted file", "none of that name");
  }
  for (const std::string& name : names) {
    if (!fs::exists(all_.waiting(name))) continue;
    moved(all_.folder_ / name, all_.aside(name));
    moved(all_.waiting(name), all_.folder_ / name);
    new_.push_back(name);
  }
}

PostedFiles::Opening::~Opening() { undo(); }

void PostedFiles::Opening::undo() {
  if (std::exchange(done_, true)) return;
  const std::lock_guard lock(all_.mutex_);
  if (!slices_.empty()) {
    for (const std::string& name : names_) moved(slices_ / name, all_.folder_ / name);
    all_.remove(slices_);
  }
  for (const std::string& name : new_) {
    all_.remove(all_.folder_ / name);
    moved(all_.aside(name), all_.folder_ / name);
  }
}

std::string PostedFiles::Opening::into_folder() {
  std::string folder;
  for (std::size_t number = 1; folder.empty() || fs::exists(all_.folder_ / folder); ++number) {
    folder = fmt::format("slices-{}", number);
  }
  slices_ = all_.folder_ / folder;
  fs::create_directory(slices_);
  for (const std::string& name : names_) fs::rename(all_.folder_ / name, slices_ / name);
  return folder;
}

void PostedFiles::Opening::keep() {
  if (std::exchange(done_, true)) return;
  const std::lock_guard lock(all_.mutex_);
  for (const std::string& name : new_) all_.remove(all_.aside(name));
}

}  // namespace gicube::samples::view
