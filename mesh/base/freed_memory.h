// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses when a program returns freed memory to the system.
#pragma once

#include <malloc.h>

namespace lumatlas {

// Call it at the start of main(). Photographs and their derived data come and go with every view, some megabytes each.
// Memory that the allocator gives back to the system must be mapped anew, page by page, for the next view, which takes
// a tenth of a build's time with photographs of two megapixels. So the allocator keeps freed pieces of up to 32 MiB,
// glibc's limit, until 256 MiB lie free.
inline void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

// Call it where memory counts more than that time: what is freed from now on in pieces of 128 KiB and more goes back to
// the system at once, instead of lying between what is kept.
inline void return_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 128 << 10);
  mallopt(M_TRIM_THRESHOLD, 128 << 10);
  malloc_trim(0);
}

}  // namespace lumatlas
