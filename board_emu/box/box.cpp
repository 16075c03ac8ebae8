#include "box.h"

#include <fmt/format.h>

#include <exception>

#include "call_filter.h"
#include "landlock.h"

namespace gicube::emu {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kHasSanitizers = true;
#elif defined(__has_feature)
constexpr bool kHasSanitizers = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
constexpr bool kHasSanitizers = false;
#endif

// Files that libraries read on demand, and that are not secret: the number of processors, and the time zone for the
// log.
const std::vector<Box::Path> kLibraries{{"/sys/devices/system/cpu", Box::Access::kRead},
                                        {"/etc/localtime", Box::Access::kRead}};

}  // namespace

Boxed enter_box(const Box& box) {
  using enum Boxed::Part;
  Boxed boxed;
  if (kHasSanitizers) {
    boxed.text = "no box: built with sanitizers";
    return boxed;
  }
  std::string files = "no limit to files, as this kernel has no Landlock";
  try {
    std::vector<Box::Path> paths = box.paths;
    if (!paths.empty()) paths.insert(paths.end(), kLibraries.begin(), kLibraries.end());
    if (const int version = restrict_files(paths); version > 0) {
      boxed.files = kInForce;
      files = fmt::format("files by Landlock {}", version);
    }
  } catch (const std::exception& error) {
    boxed.files = kFailed;
    files = fmt::format("no limit to files, as Landlock failed: {}", error.what());
  }
  std::string calls = "no limit to system calls, as this kernel has no filter for them";
  try {
    if (filter_calls(!box.paths.empty(), box.has_clients)) {
      boxed.calls = kInForce;
      calls = "system calls by a filter";
    }
  } catch (const std::exception& error) {
    boxed.calls = kFailed;
    calls = fmt::format("no limit to system calls, as their filter failed: {}", error.what());
  }
  boxed.text = fmt::format("box: {}; {}", files, calls);
  return boxed;
}

}  // namespace gicube::emu
