// SPDX-License-Identifier: GPL-3.0-or-later
// Names and checks of image formats. image_encoding.cpp encodes the images themselves.
#include <stdexcept>
#include <string>

#include "atlas/images/photograph.h"

namespace lumatlas {

namespace {

struct FormatNames {
  const char* ending;
  const char* mime_type;
};

FormatNames names_of(ImageFormat format) {
  if (format == ImageFormat::jpeg) return {".jpg", "image/jpeg"};
  if (format == ImageFormat::webp) return {".webp", "image/webp"};
  return {".png", "image/png"};
}

}  // namespace

const char* ending(ImageFormat format) {
  return names_of(format).ending;
}

const char* mime_type(ImageFormat format) {
  return names_of(format).mime_type;
}

void check(const ImageCoding& coding) {
  if (coding.quality >= 1 && coding.quality <= 100) return;
  throw std::invalid_argument("image: quality is " + std::to_string(coding.quality) + ", must be in [1, 100]");
}

}  // namespace lumatlas
