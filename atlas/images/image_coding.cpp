// SPDX-License-Identifier: GPL-3.0-or-later
// What is said of a picture's form. The pictures themselves are encoded by image_encoding.cpp.
#include <stdexcept>
#include <string>

#include "atlas/images/photograph.h"

namespace lumatlas {

const char* ending(ImageFormat format) {
  switch (format) {
    case ImageFormat::jpeg:
      return ".jpg";
    case ImageFormat::webp:
      return ".webp";
    default:
      return ".png";
  }
}

const char* mime_type(ImageFormat format) {
  switch (format) {
    case ImageFormat::jpeg:
      return "image/jpeg";
    case ImageFormat::webp:
      return "image/webp";
    default:
      return "image/png";
  }
}

void check(const ImageCoding& coding) {
  if (coding.quality >= 1 && coding.quality <= 100) return;
  throw std::invalid_argument("image: quality is " + std::to_string(coding.quality) + ", must be in [1, 100]");
}

}  // namespace lumatlas
