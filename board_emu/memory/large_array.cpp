#include "memory/large_array.h"

#include <sys/mman.h>

namespace gicube::emu {

void* allocate_large(std::size_t bytes) {
  if (bytes < kHugePage) return ::operator new(bytes);
  void* const place = ::operator new (bytes, std::align_val_t{kHugePage});
#ifdef MADV_HUGEPAGE
  // Whole huge pages only: the rest would take memory that nobody asked for. A wish, so what comes of it does not matter.
  static_cast<void>(madvise(place, bytes / kHugePage * kHugePage, MADV_HUGEPAGE));
#endif
  return place;
}

void free_large(void* place, std::size_t bytes) noexcept {
  if (bytes < kHugePage) return ::operator delete(place);
  ::operator delete (place, std::align_val_t{kHugePage});
}

}  // namespace gicube::emu
