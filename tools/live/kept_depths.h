// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/live/: keeps the depth images that a live surface was fused of, so that they can be taken out of it
// again. They are rounded and packed, and lie in memory up to a bound, and beyond that in a temporary file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <span>
#include <vector>

#include "mesh/base/temporary_entry.h"

namespace lumatlas {

// Depths in whole steps, row by row.
struct RoundedDepth {
  double unit = 0;                   // scene units that a step is, > 0
  std::vector<std::uint16_t> steps;  // 0: not measured
};

// Rounds depths to steps of `unit`, or of as much more as the farthest depth needs. What was measured has at least one
// step; depths that are negative or not finite count as not measured.
[[nodiscard]] RoundedDepth rounded_depth(std::span<const float> depth, double unit);
[[nodiscard]] std::vector<float> depths_of(const RoundedDepth& rounded);

// Returns about a byte for each pixel of a smooth surface, and at most three.
[[nodiscard]] std::vector<std::uint8_t> packed(const RoundedDepth& rounded);
// Returns what packed() was given, to the bit.
[[nodiscard]] RoundedDepth unpacked(std::span<const std::uint8_t> bytes);

class KeptDepths {
 public:
  // Images beyond `memory_bytes` go to a file in `folder`, which is made when the first one does and goes with this
  // object. Images beyond `most_bytes`, memory and file together, are not kept.
  KeptDepths(std::filesystem::path folder, std::uint64_t memory_bytes, std::uint64_t most_bytes);

  // Returns the image's number, from 0 on; none if it is not kept: there is no room, or the disk refuses.
  [[nodiscard]] std::optional<std::size_t> keep(const RoundedDepth& image);
  // Throws InputError if the disk refuses.
  [[nodiscard]] RoundedDepth image(std::size_t number);
  [[nodiscard]] std::uint64_t bytes() const { return memory_bytes_ + file_bytes_; }

 private:
  struct Place {
    std::vector<std::uint8_t> bytes;  // empty: it is in the file
    std::uint64_t offset = 0;         // of the file
    std::size_t size = 0;
  };
  bool write(std::span<const std::uint8_t> bytes);

  std::filesystem::path folder_;
  std::uint64_t most_memory_, most_bytes_, memory_bytes_ = 0, file_bytes_ = 0;
  std::vector<Place> places_;
  std::optional<TemporaryEntry> entry_;
  std::fstream file_;
};

}  // namespace lumatlas
