// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the memory that C++ code takes, so that a test can state how it grows. A program that links
// lumatlas_allocation_peak has its operator new and delete replaced.
#pragma once

#include <cstddef>

namespace lumatlas {

// False under a sanitizer, which has an operator new of its own: then all figures are 0 and a test skips them.
[[nodiscard]] bool allocations_are_counted();

// The largest number of bytes, of all threads, that operator new handed out and delete did not take back, above what
// that number was at the beginning. One object at a time.
class AllocationPeak {
 public:
  AllocationPeak();
  AllocationPeak(const AllocationPeak&) = delete;
  AllocationPeak& operator=(const AllocationPeak&) = delete;
  [[nodiscard]] std::size_t bytes() const;

 private:
  std::size_t before_;
};

}  // namespace lumatlas
