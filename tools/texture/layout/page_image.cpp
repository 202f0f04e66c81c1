// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/layout/page_image.h"

#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

[[noreturn]] void fail(const Photograph& page, const std::string& reason) {
  std::string text = "a page of ";
  text.append(std::to_string(page.width)).append("x").append(std::to_string(page.height));
  throw InputError(text.append(" cannot be encoded as WebP: ").append(reason));
}

std::vector<std::uint8_t> encode_webp(const Photograph& page, int quality) {
  if (page.rgb.empty() || page.rgb.size() != 3 * std::size_t{page.width} * page.height) {
    throw std::invalid_argument("texture: a page has not three values for each of its texels");
  }
  if (page.width > kLongestWebp || page.height > kLongestWebp) {
    fail(page, "it has at most " + std::to_string(kLongestWebp) + " texels a side");
  }
  return encode_image(page, {ImageFormat::webp, quality});
}

}  // namespace

const char* ending(PageFormat format) {
  if (format == PageFormat::webp) return ".webp";
  return ending(format == PageFormat::jpeg ? ImageFormat::jpeg : ImageFormat::png);
}

const char* mime_type(PageFormat format) {
  if (format == PageFormat::webp) return "image/webp";
  return mime_type(format == PageFormat::jpeg ? ImageFormat::jpeg : ImageFormat::png);
}

void check(const PageCoding& coding) {
  check(ImageCoding{ImageFormat::jpeg, coding.quality});
}

std::vector<std::uint8_t> encode_page(const Photograph& page, const PageCoding& coding) {
  check(coding);
  if (coding.format == PageFormat::webp) return encode_webp(page, coding.quality);
  return encode_image(page, {coding.format == PageFormat::jpeg ? ImageFormat::jpeg : ImageFormat::png, coding.quality});
}

}  // namespace lumatlas
