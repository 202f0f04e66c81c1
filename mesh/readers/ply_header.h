// SPDX-License-Identifier: GPL-3.0-or-later
// The header of a PLY file: what elements with what properties follow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lumatlas {

enum class PlyEncoding { Ascii, BinaryLittleEndian, BinaryBigEndian };
enum class PlyType : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

[[nodiscard]] std::size_t byte_count(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::Float32;  // for a list, the type of its items
  bool is_list = false;
  PlyType count_type = PlyType::Uint8;  // for a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;  // claimed, see check_counts()
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Ascii;
  char line_feed = '\n';  // also in an ASCII body: '\r' if the header's lines end with it alone
  std::vector<PlyElement> elements;
  std::size_t body = 0;  // byte offset
};

// Throws InputError that begins with `path`, and names the header's line.
[[nodiscard]] PlyHeader parse_ply_header(std::string_view contents, const std::string& path);

// Throws InputError if an element claims more records than the bytes after the header can hold, with every list empty.
void check_counts(const PlyHeader& header, std::size_t contents_bytes, const std::string& path);

}  // namespace lumatlas
