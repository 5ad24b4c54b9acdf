#pragma once

// Counts heap allocations of the whole program. Include it in exactly one translation unit of a
// test executable, because it replaces the global operator new.

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace srslam::test {

inline std::atomic<std::size_t>& allocation_count() {
  static std::atomic<std::size_t> count{0};
  return count;
}

/// Allocations while `body` ran, in every thread.
template <typename Body>
std::size_t count_allocations(const Body& body) {
  const std::size_t before = allocation_count().load();
  body();
  return allocation_count().load() - before;
}

inline void* counted_allocation(std::size_t size, std::size_t alignment) {
  ++allocation_count();
  if (size == 0) size = 1;
  // aligned_alloc() wants a multiple of the alignment.
  void* memory = alignment == 0 ? std::malloc(size)
                                : std::aligned_alloc(
                                      alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace srslam::test

// The library promises no allocation; a replaced operator new is the way to see one. The array and
// nothrow forms of the standard library call these. Not inlined, because GCC would otherwise see
// free() applied to the result of operator new and call that a mismatch.
// NOLINTBEGIN(misc-definitions-in-headers): one translation unit includes this, see above
[[gnu::noinline]] void* operator new(std::size_t size) {
  return srslam::test::counted_allocation(size, 0);
}
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return srslam::test::counted_allocation(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
// NOLINTEND(misc-definitions-in-headers)
