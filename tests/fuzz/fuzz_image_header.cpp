// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstddef>
#include <cstdlib>
#include <sstream>
#include <string>

#include "atlas/images/files/image_header.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream file(std::string(reinterpret_cast<const char*>(data), size));
  const auto header = lumatlas::read_jpeg_header(file);
  if (header && (header->exif.orientation < 1 || header->exif.orientation > 8)) std::abort();
  (void)lumatlas::jpeg_is_complete({data, size});
  (void)lumatlas::png_is_complete({data, size});
  return 0;
}
