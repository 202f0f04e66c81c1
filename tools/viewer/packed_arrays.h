// SPDX-License-Identifier: GPL-3.0-or-later
// Packs arrays of whole numbers so that a page can unpack them without any library. Values that change little from one
// entry to the next are written as differences. The bytes of all entries follow each other by significance, and all of
// it is deflated (RFC 1950), which every browser can undo (DecompressionStream). The page's half is
// page/packed_arrays.js.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace lumatlas {

enum class PackedCoding {
  plain,       // the values themselves
  difference,  // to the entry before in the same component, alternating in sign: 0, -1, 1, -2, 2 become 0 to 4
  corners,     // vertices that are numbered in the order in which they first come: how far below the next new one
};

// For few bytes, or for little time.
enum class DeflateEffort { least = 1, most = 9 };

class PackedArrays {
 public:
  // Throws std::invalid_argument unless the values come in whole entries, and for `corners` out of order.
  void add(const std::string& name, std::span<const std::uint32_t> values, std::uint32_t components,
           PackedCoding coding);

  // For each array its name, components, entries, coding, and how many bytes of each value are there.
  [[nodiscard]] const nlohmann::json& description() const { return description_; }
  [[nodiscard]] std::vector<std::uint8_t> deflated(DeflateEffort effort = DeflateEffort::most) const;

 private:
  nlohmann::json description_ = nlohmann::json::array();
  std::vector<std::uint8_t> bytes_;
};

// zlib's format. Throws std::runtime_error if zlib fails, for lack of memory.
[[nodiscard]] std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes,
                                                 DeflateEffort effort = DeflateEffort::most);

}  // namespace lumatlas
