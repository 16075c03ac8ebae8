// An observer for tests. It opens the file that GICUBE_TEST_OBSERVED names as it is loaded, and writes to it in its box
// what it has seen.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "gicube/observer.h"

namespace {

std::FILE* file = nullptr;
unsigned long long events = 0, rays = 0;
bool in_order = true;

void take(const gicube_event* some, std::size_t count) {
  if (std::strcmp(std::getenv("GICUBE_TEST_OBSERVER"), "leaves") == 0) std::_Exit(3);
  for (volatile bool loops = std::strcmp(std::getenv("GICUBE_TEST_OBSERVER"), "loops") == 0; loops;) continue;
  for (std::size_t i = 0; i < count; ++i) {
    in_order = in_order && some[i].ray == events && some[i].size == sizeof(gicube_event);
    ++events;
    rays += some[i].ray;
  }
}

void end() {
  std::FILE* const other = std::fopen("/etc/passwd", "r");
  std::fprintf(file, "%llu %llu %s %s", events, rays, in_order ? "in order" : "out of order",
               other == nullptr ? "boxed" : "free");
  std::fclose(file);
}

}  // namespace

extern "C" const gicube_observer* gicube_observer_describe() {
  static const gicube_observer observer{GICUBE_OBSERVER_ABI, sizeof(gicube_observer), "counts", take, end};
  file = std::fopen(std::getenv("GICUBE_TEST_OBSERVED"), "w");
  return &observer;
}
