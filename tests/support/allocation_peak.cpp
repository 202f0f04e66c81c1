// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/allocation_peak.h"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace lumatlas {
namespace {

std::atomic<std::size_t> live = 0;
std::atomic<std::size_t> peak = 0;

}  // namespace

AllocationPeak::AllocationPeak() : before_(live) {
  peak = before_;
}

std::size_t AllocationPeak::bytes() const {
  const std::size_t most = peak;
  return most > before_ ? most - before_ : 0;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LUMATLAS_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LUMATLAS_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef LUMATLAS_COUNTS_ALLOCATIONS
#define LUMATLAS_COUNTS_ALLOCATIONS 1
#endif

bool allocations_are_counted() {
  return LUMATLAS_COUNTS_ALLOCATIONS != 0;
}

#if LUMATLAS_COUNTS_ALLOCATIONS
namespace {

void* counted(void* memory) {
  if (memory == nullptr) throw std::bad_alloc();
  const std::size_t size = malloc_usable_size(memory);
  const std::size_t now = live.fetch_add(size) + size;
  std::size_t most = peak;
  while (most < now && !peak.compare_exchange_weak(most, now)) {
  }
  return memory;
}

void release(void* memory) {
  if (memory != nullptr) live -= malloc_usable_size(memory);
  std::free(memory);
}

}  // namespace
#endif

}  // namespace lumatlas

#if LUMATLAS_COUNTS_ALLOCATIONS
// The other forms of the standard library call these.
void* operator new(std::size_t size) {
  return lumatlas::counted(std::malloc(size == 0 ? 1 : size));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  void* memory = nullptr;
  if (posix_memalign(&memory, static_cast<std::size_t>(alignment), size == 0 ? 1 : size) != 0) memory = nullptr;
  return lumatlas::counted(memory);
}
void operator delete(void* memory) noexcept {
  lumatlas::release(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  lumatlas::release(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  lumatlas::release(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  lumatlas::release(memory);
}
#endif
