#include "common/progress.h"

#include <unistd.h>

namespace gicube::samples {
namespace {

constexpr const char* kEraseLine = "\r\x1b[K";

}  // namespace

ProgressLine::ProgressLine(bool shown, std::FILE* stream)
    : stream_(stream), shown_(shown && ::isatty(::fileno(stream)) != 0) {}

ProgressLine::~ProgressLine() { clear(); }

void ProgressLine::show(const std::string& what) {
  if (!shown_) return;
  std::fprintf(stream_, "%s%s", kEraseLine, what.c_str());
  std::fflush(stream_);
  dirty_ = true;
  percent_ = -1;
}

Progress ProgressLine::parts(const std::string& what) {
  if (!shown_) return {};
  show(what);
  return [this, what](std::uint32_t done, std::uint32_t all) {
    const int percent = all == 0 ? 100 : static_cast<int>(std::uint64_t{done} * 100 / all);
    if (percent == percent_) return;
    show(what + " " + std::to_string(percent) + "%");
    percent_ = percent;
  };
}

void ProgressLine::clear() {
  if (!dirty_) return;
  std::fprintf(stream_, "%s", kEraseLine);
  std::fflush(stream_);
  dirty_ = false;
}

}  // namespace gicube::samples
