// SPDX-License-Identifier: GPL-3.0-or-later
// How a program returns freed memory to the system.
#pragma once

#include <malloc.h>

namespace lumatlas {

// For the start of main(). Photographs and what is made of them come and go with every view, some megabytes each. What
// the allocator gives back to the system has to be mapped anew, page by page, when the next one comes: a tenth of the
// time of a build, where photographs have two megapixels. So it keeps what is freed: pieces of up to 32 MiB, glibc's
// limit, until 256 MiB lie free.
inline void keep_freed_memory() {
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 256 << 20);
}

}  // namespace lumatlas
