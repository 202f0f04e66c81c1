// SPDX-License-Identifier: GPL-3.0-or-later
// Source: W3C, Portable Network Graphics (PNG) Specification, third edition, sections 5 (chunks) and 9 (filters).
#include "atlas/images/files/grey_png.h"

#include <zlib.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace lumatlas {

namespace {

constexpr std::uint8_t kUp = 2;  // the filter that writes what differs from the row above

void add_word(std::vector<std::uint8_t>& bytes, std::uint32_t word) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
}

void add_chunk(std::vector<std::uint8_t>& file, std::string_view type, std::span<const std::uint8_t> data) {
  add_word(file, static_cast<std::uint32_t>(data.size()));
  const std::size_t first = file.size();
  file.insert(file.end(), type.begin(), type.end());
  file.insert(file.end(), data.begin(), data.end());
  add_word(file, static_cast<std::uint32_t>(crc32(0, &file[first], static_cast<uInt>(file.size() - first))));
}

// Each row behind the number of its filter.
std::vector<std::uint8_t> filtered_rows(std::span<const std::uint8_t> values, std::uint32_t width) {
  std::vector<std::uint8_t> rows;
  rows.reserve(values.size() + values.size() / width);
  for (std::size_t pixel = 0; pixel < values.size(); ++pixel) {
    if (pixel % width == 0) rows.push_back(kUp);
    rows.push_back(static_cast<std::uint8_t>(values[pixel] - (pixel < width ? 0 : values[pixel - width])));
  }
  return rows;
}

std::vector<std::uint8_t> compressed(const std::vector<std::uint8_t>& rows, PngEffort effort) {
  std::vector<std::uint8_t> bytes(compressBound(rows.size()));
  uLongf size = bytes.size();
  const int level = effort == PngEffort::least ? Z_BEST_SPEED : Z_BEST_COMPRESSION;
  if (compress2(bytes.data(), &size, rows.data(), rows.size(), level) != Z_OK) {
    throw std::runtime_error("zlib cannot deflate " + std::to_string(rows.size()) + " bytes");
  }
  bytes.resize(size);
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> grey_png(std::span<const std::uint8_t> values, std::uint32_t width, std::uint32_t height,
                                   PngEffort effort) {
  if (values.empty() || values.size() != std::size_t{width} * height) {
    throw std::invalid_argument("grey PNG: has " + std::to_string(values.size()) + " values, must have " +
                                std::to_string(width) + " x " + std::to_string(height));
  }
  std::vector<std::uint8_t> header;
  add_word(header, width);
  add_word(header, height);
  header.insert(header.end(), {8, 0, 0, 0, 0});  // bits; grey; deflate; filters by row; not interlaced
  std::vector<std::uint8_t> file{0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
  add_chunk(file, "IHDR", header);
  add_chunk(file, "IDAT", compressed(filtered_rows(values, width), effort));
  add_chunk(file, "IEND", {});
  return file;
}

}  // namespace lumatlas
