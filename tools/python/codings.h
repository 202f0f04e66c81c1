// SPDX-License-Identifier: GPL-3.0-or-later
// Converts the names and qualities of image formats that Python gives.
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/images/photograph.h"
#include "tools/python/names.h"

namespace lumatlas::python {

// Throws std::invalid_argument for a format that is none, and for a quality of PNG, which is exact.
[[nodiscard]] inline ImageCoding image_coding(const std::string& image, std::optional<int> quality) {
  static const std::array<std::pair<std::string, ImageFormat>, 3> kFormats{
      {{"png", ImageFormat::png}, {"jpeg", ImageFormat::jpeg}, {"jpg", ImageFormat::jpeg}}};
  ImageCoding coding{value_named(kFormats, "image", image)};
  if (quality && coding.format == ImageFormat::png) {
    throw std::invalid_argument("quality is " + std::to_string(*quality) + ", but image is png, which is exact");
  }
  coding.quality = quality.value_or(coding.quality);
  check(coding);
  return coding;
}

}  // namespace lumatlas::python
