// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: buffer views of glTF that EXT_meshopt_compression compressed, decoded by meshoptimizer.
//
// Source: the extension's page in the Khronos registry, sections "JSON schema" and "Content guidelines".
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lumatlas {

inline constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

// No bytes decode to more than this many times as many: 256 equal bytes take 4 of the codec for attributes, whose
// ratio is the largest.
inline constexpr std::uint64_t kMostMeshoptGrowth = 64;

enum class MeshoptMode { attributes, triangles, indices };
enum class MeshoptFilter { none, octahedral, quaternion, exponential };

// Take the names of the extension, such as "TRIANGLES"; return nothing for any other name.
[[nodiscard]] std::optional<MeshoptMode> meshopt_mode(std::string_view name);
[[nodiscard]] std::optional<MeshoptFilter> meshopt_filter(std::string_view name);

// The size and layout of a compressed view's decoded bytes.
struct MeshoptView {
  MeshoptMode mode = MeshoptMode::attributes;
  MeshoptFilter filter = MeshoptFilter::none;
  std::uint32_t count = 0;   // elements; of triangles: of their corners
  std::uint32_t stride = 0;  // bytes of an element

  [[nodiscard]] std::uint64_t decoded_bytes() const { return std::uint64_t{count} * stride; }
};

// The rule of the extension that the view breaks, such as "its stride is 3, must be 2 or 4"; empty if none is broken.
[[nodiscard]] std::string broken_rule(const MeshoptView& view, std::size_t compressed_bytes);

// The elements, `stride` bytes each; none if the bytes are damaged. Indices may be any numbers. Throws
// std::invalid_argument if a rule is broken, before anything is allocated.
[[nodiscard]] std::optional<std::vector<unsigned char>> decoded(const MeshoptView& view,
                                                                std::span<const unsigned char> compressed);

}  // namespace lumatlas
