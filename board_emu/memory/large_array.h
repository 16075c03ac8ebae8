// Arrays of megabytes that are filled once and then gathered from, such as the decoded volume. They use huge pages if
// the host has them: otherwise a first frame waits for thousands of page faults, and gathers wait for address
// translation.
#pragma once

#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <vector>

namespace gicube::emu {

inline constexpr std::size_t kHugePage = std::size_t{1} << 21;  // bytes, on x86-64 and on AArch64 with 4 KiB pages

// Like operator new and delete. From kHugePage bytes on, memory is aligned to that and requests huge pages, which the
// host provides if transparent_hugepage is madvise or always.
inline void* allocate_large(std::size_t bytes) {
  if (bytes < kHugePage) return ::operator new(bytes);
  void* const place = ::operator new (bytes, std::align_val_t{kHugePage});
#ifdef MADV_HUGEPAGE
  // Only whole huge pages, because a partial one would waste memory. This is a hint, so its result does not matter.
  static_cast<void>(madvise(place, bytes / kHugePage * kHugePage, MADV_HUGEPAGE));
#endif
  return place;
}
inline void free_large(void* place, std::size_t bytes) noexcept {
  if (bytes < kHugePage) return ::operator delete(place);
  ::operator delete (place, std::align_val_t{kHugePage});
}

template <typename T>
struct LargeAllocator {
  static_assert(std::is_trivially_copyable_v<T> && std::is_trivially_destructible_v<T>);
  using value_type = T;  // NOLINT(readability-identifier-naming): required by containers

  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>&) {}

  T* allocate(std::size_t count) { return static_cast<T*>(allocate_large(count * sizeof(T))); }
  void deallocate(T* place, std::size_t count) noexcept { free_large(place, count * sizeof(T)); }

  // Elements without a value are not zeroed, because they will be overwritten.
  template <typename U>
  void construct(U*) {}
  template <typename U, typename Value>
  void construct(U* place, const Value& value) {
    ::new (static_cast<void*>(place)) U(value);
  }

  friend bool operator==(const LargeAllocator&, const LargeAllocator&) { return true; }
};

// resize(n) leaves new elements uninitialised, resize(n, value) does not.
template <typename T>
using LargeArray = std::vector<T, LargeAllocator<T>>;

// Bytes whose memory returns to the host as soon as they are freed: from kMapped bytes on they are mapped pages of
// their own. Memory of malloc would stay with the process.
template <typename T>
struct ReturnedAllocator {
  using value_type = T;  // NOLINT(readability-identifier-naming): required by containers
  static constexpr std::size_t kMapped = std::size_t{64} << 10;  // bytes; chosen: sixteen pages or more

  ReturnedAllocator() = default;
  template <typename U>
  ReturnedAllocator(const ReturnedAllocator<U>&) {}

  T* allocate(std::size_t count) {
    if (count * sizeof(T) < kMapped) return static_cast<T*>(::operator new(count * sizeof(T)));
    void* const place = mmap(nullptr, count * sizeof(T), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (place == MAP_FAILED) throw std::bad_alloc();
    return static_cast<T*>(place);
  }
  void deallocate(T* place, std::size_t count) noexcept {
    if (count * sizeof(T) < kMapped) return ::operator delete(place);
    munmap(place, count * sizeof(T));
  }
  friend bool operator==(const ReturnedAllocator&, const ReturnedAllocator&) { return true; }
};
using ReturnedBytes = std::vector<std::uint8_t, ReturnedAllocator<std::uint8_t>>;

}  // namespace gicube::emu
