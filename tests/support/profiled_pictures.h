// SPDX-License-Identifier: GPL-3.0-or-later
// Small PNG, TIFF and WebP files with any bytes where an ICC profile should be. They are put together here because
// writers of these formats refuse damaged profiles.
#pragma once

#include <zlib.h>

#include <cstdint>
#include <string>
#include <string_view>

namespace lumatlas {

enum class ByteOrder { little, big };

inline void append_number(std::string& bytes, std::uint64_t value, int count, ByteOrder order) {
  for (int i = 0; i < count; ++i) {
    bytes += static_cast<char>(value >> (8 * (order == ByteOrder::big ? count - 1 - i : i)) & 0xff);
  }
}

inline std::string deflated(std::string_view bytes) {
  uLongf size = compressBound(bytes.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  packed.resize(size);
  return packed;
}

inline void append_png_chunk(std::string& png, std::string_view type, std::string_view data) {
  append_number(png, data.size(), 4, ByteOrder::big);
  const std::size_t summed = png.size();
  png.append(type).append(data);
  append_number(png, crc32_z(0, reinterpret_cast<const Bytef*>(png.data() + summed), png.size() - summed), 4,
                ByteOrder::big);
}

constexpr std::size_t kProfiledSide = 2;  // pixels of both files below, all of this colour
constexpr std::string_view kProfiledColor = "\xc8\x78\x5a";

// An iCCP chunk with this data, which need be no packed profile.
inline std::string png_with_profile_chunk(std::string_view data) {
  std::string png = "\x89PNG\r\n\x1a\n", header, rows;
  for (int i = 0; i < 2; ++i) append_number(header, kProfiledSide, 4, ByteOrder::big);
  header.append("\x08\x02\0\0\0", 5);  // 8 bits, RGB
  for (std::size_t y = 0; y < kProfiledSide; ++y) {
    rows += '\0';
    for (std::size_t x = 0; x < kProfiledSide; ++x) rows += kProfiledColor;
  }
  append_png_chunk(png, "IHDR", header);
  append_png_chunk(png, "iCCP", data);
  append_png_chunk(png, "IDAT", deflated(rows));
  append_png_chunk(png, "IEND", "");
  return png;
}

inline std::string png_with_profile(std::string_view profile) {
  return png_with_profile_chunk(std::string("name\0\0", 6) + deflated(profile));
}

// `plain` is a WebP file whose pixels are `width` x `height`, without a profile: one chunk of pixels, VP8 or VP8L.
inline std::string webp_with_profile(std::string_view plain, std::uint32_t width, std::uint32_t height,
                                     std::string_view profile) {
  constexpr std::size_t kFileHeader = 12;
  constexpr std::uint64_t kHasProfile = 0x20;
  std::string chunks = "WEBPVP8X";
  append_number(chunks, 10, 4, ByteOrder::little);
  append_number(chunks, kHasProfile, 4, ByteOrder::little);
  append_number(chunks, width - 1, 3, ByteOrder::little);
  append_number(chunks, height - 1, 3, ByteOrder::little);
  chunks += "ICCP";
  append_number(chunks, profile.size(), 4, ByteOrder::little);
  chunks.append(profile).append(profile.size() % 2, '\0').append(plain.substr(kFileHeader));
  std::string webp = "RIFF";
  append_number(webp, chunks.size(), 4, ByteOrder::little);
  return webp + chunks;
}

// Header, directory, pixels, profile.
inline std::string tiff_with_profile(std::string_view profile, ByteOrder order = ByteOrder::little,
                                     bool big_tiff = false) {
  constexpr std::uint64_t kEntries = 10, kShort = 3, kLong = 4, kUndefined = 7;
  constexpr std::uint64_t kPixelBytes = 3 * kProfiledSide * kProfiledSide;
  const int word = big_tiff ? 8 : 4;
  const std::uint64_t directory = big_tiff ? 16 : 8;
  const std::uint64_t pixels = directory + (big_tiff ? 8 + 20 * kEntries + 8 : 2 + 12 * kEntries + 4);
  const std::uint64_t bits = pixels + kPixelBytes;  // classic: three of them need more than an entry has
  std::string tiff = order == ByteOrder::big ? "MM" : "II";
  append_number(tiff, big_tiff ? 43 : 42, 2, order);
  if (big_tiff) append_number(tiff, 8, 2, order), append_number(tiff, 0, 2, order);
  append_number(tiff, directory, word, order);
  append_number(tiff, kEntries, big_tiff ? 8 : 2, order);
  const auto entry = [&](std::uint64_t tag, std::uint64_t type, std::uint64_t count, std::uint64_t value) {
    append_number(tiff, tag, 2, order);
    append_number(tiff, type, 2, order);
    append_number(tiff, count, word, order);
    const int bytes = type == kShort && count == 1 ? 2 : word == 8 && type == kLong ? 4 : word;
    append_number(tiff, value, bytes, order);
    append_number(tiff, 0, word - bytes, order);
  };
  entry(256, kShort, 1, kProfiledSide);  // width
  entry(257, kShort, 1, kProfiledSide);  // height
  if (big_tiff) {
    append_number(tiff, 258, 2, order), append_number(tiff, kShort, 2, order), append_number(tiff, 3, word, order);
    for (const int sample_bits : {8, 8, 8, 0}) append_number(tiff, sample_bits, 2, order);
  } else {
    entry(258, kShort, 3, bits);
  }
  entry(259, kShort, 1, 1);  // not compressed
  entry(262, kShort, 1, 2);  // RGB
  entry(273, kLong, 1, pixels);
  entry(277, kShort, 1, 3);  // samples of a pixel
  entry(278, kShort, 1, kProfiledSide);
  entry(279, kLong, 1, kPixelBytes);
  entry(34675, kUndefined, profile.size(), bits + 6);
  append_number(tiff, 0, word, order);  // no further directory
  for (std::size_t i = 0; i < kProfiledSide * kProfiledSide; ++i) tiff += kProfiledColor;
  for (int i = 0; i < 3; ++i) append_number(tiff, 8, 2, order);
  return tiff.append(profile);
}

}  // namespace lumatlas
