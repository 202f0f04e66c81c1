// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/meshopt_compression.h"

#include <meshoptimizer.h>

#include <stdexcept>

namespace lumatlas {

std::optional<MeshoptMode> meshopt_mode(std::string_view name) {
  if (name == "ATTRIBUTES") return MeshoptMode::attributes;
  if (name == "TRIANGLES") return MeshoptMode::triangles;
  if (name == "INDICES") return MeshoptMode::indices;
  return std::nullopt;
}

std::optional<MeshoptFilter> meshopt_filter(std::string_view name) {
  if (name == "NONE") return MeshoptFilter::none;
  if (name == "OCTAHEDRAL") return MeshoptFilter::octahedral;
  if (name == "QUATERNION") return MeshoptFilter::quaternion;
  if (name == "EXPONENTIAL") return MeshoptFilter::exponential;
  return std::nullopt;
}

std::string broken_rule(const MeshoptView& view, std::size_t compressed_bytes) {
  const auto stride = [&](const char* rule) {
    return "its stride is " + std::to_string(view.stride) + ", must be " + rule;
  };
  if (view.mode == MeshoptMode::attributes) {
    if (view.stride == 0 || view.stride > 256 || view.stride % 4 != 0) return stride("a multiple of 4 up to 256");
  } else if (view.stride != 2 && view.stride != 4) {
    return stride("2 or 4");
  }
  if (view.mode == MeshoptMode::triangles && view.count % 3 != 0) {
    return "its count is " + std::to_string(view.count) + ", must be a multiple of 3";
  }
  if (view.filter != MeshoptFilter::none && view.mode != MeshoptMode::attributes) {
    return "its indices have a filter, which only attributes may have";
  }
  if (view.filter == MeshoptFilter::octahedral && view.stride != 4 && view.stride != 8) return stride("4 or 8");
  if (view.filter == MeshoptFilter::quaternion && view.stride != 8) return stride("8");
  if (view.decoded_bytes() > kMostMeshoptGrowth * compressed_bytes) {
    return "its count is " + std::to_string(view.count) + ", too many for " + std::to_string(compressed_bytes) +
           " compressed bytes";
  }
  return {};
}

std::optional<std::vector<unsigned char>> decoded(const MeshoptView& view, std::span<const unsigned char> compressed) {
  if (const std::string broken = broken_rule(view, compressed.size()); !broken.empty()) {
    throw std::invalid_argument("meshopt view: " + broken);
  }
  std::vector<unsigned char> bytes(view.decoded_bytes());
  if (bytes.empty()) return bytes;
  const auto decode = [&]() -> int {
    switch (view.mode) {
      case MeshoptMode::triangles:
        return meshopt_decodeIndexBuffer(bytes.data(), view.count, view.stride, compressed.data(), compressed.size());
      case MeshoptMode::indices:
        return meshopt_decodeIndexSequence(bytes.data(), view.count, view.stride, compressed.data(), compressed.size());
      case MeshoptMode::attributes:
        break;
    }
    return meshopt_decodeVertexBuffer(bytes.data(), view.count, view.stride, compressed.data(), compressed.size());
  };
  if (decode() != 0) return std::nullopt;
  switch (view.filter) {
    case MeshoptFilter::octahedral:
      meshopt_decodeFilterOct(bytes.data(), view.count, view.stride);
      break;
    case MeshoptFilter::quaternion:
      meshopt_decodeFilterQuat(bytes.data(), view.count, view.stride);
      break;
    case MeshoptFilter::exponential:
      meshopt_decodeFilterExp(bytes.data(), view.count, view.stride);
      break;
    case MeshoptFilter::none:
      break;
  }
  return bytes;
}

}  // namespace lumatlas
