// SPDX-License-Identifier: GPL-3.0-or-later
// For LD_PRELOAD: the libraries that LUMATLAS_TEST_HIDES names, with spaces between them, cannot be loaded.
#include <dlfcn.h>

#include <cstdlib>
#include <string>

extern "C" void* dlopen(const char* name, int flags) noexcept {
  const char* const hidden = std::getenv("LUMATLAS_TEST_HIDES");
  const bool is_hidden =
      name && hidden && (std::string(" ") + hidden + " ").find(std::string(" ") + name + " ") != std::string::npos;
  if (is_hidden) return nullptr;
  using Open = void* (*)(const char*, int);
  return reinterpret_cast<Open>(dlsym(RTLD_NEXT, "dlopen"))(name, flags);
}
