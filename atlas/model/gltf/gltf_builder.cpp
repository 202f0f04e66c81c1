// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/gltf_builder.h"

#include <meshoptimizer.h>

#include <cmath>
#include <cstring>
#include <map>
#include <stdexcept>
#include <utility>

#include "atlas/model/gltf/meshopt_compression.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr int kFallback = -1;  // stands for the buffer without bytes, whose number is known last

std::size_t component_bytes(int component) {
  return component == kGltfByte ? 1 : component == kGltfShort ? 2 : 4;
}

std::size_t element_bytes(const GltfElement& element) {
  static const std::map<std::string, std::size_t> components{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  return component_bytes(element.component) * components.at(element.type);
}

// The values as the filter of the extension has them: a mantissa of 24 bits and a power of two, the same for all.
std::vector<std::uint32_t> on_grid(std::span<const std::byte> values) {
  std::vector<float> floats(values.size() / sizeof(float));
  std::memcpy(floats.data(), values.data(), values.size());
  int exponent = 127;
  for (const float value : floats) {
    if (value == 0) continue;
    int of_value = 0;
    auto mantissa = static_cast<std::uint32_t>(std::abs(std::frexp(value, &of_value)) * (1 << 24));
    of_value -= 24;
    for (; mantissa % 2 == 0; mantissa /= 2) ++of_value;
    exponent = std::min(exponent, of_value);
  }
  std::vector<std::uint32_t> coded;
  coded.reserve(floats.size());
  for (const float value : floats) {
    const double mantissa = std::ldexp(static_cast<double>(value), -exponent);
    if (std::abs(mantissa) >= 1 << 23) throw std::invalid_argument("glTF builder: values are not on a grid of 24 bits");
    coded.push_back((static_cast<std::uint32_t>(static_cast<std::int32_t>(mantissa)) & 0xFFFFFF) |
                    static_cast<std::uint32_t>(exponent) << 24);
  }
  return coded;
}

std::vector<unsigned char> coded(std::span<const std::byte> values, std::size_t stride, GltfPacking packing) {
  std::vector<unsigned char> result;
  const std::size_t count = values.size() / stride;
  if (packing == GltfPacking::triangles) {
    std::vector<unsigned int> corners(values.size() / sizeof(unsigned int));
    std::memcpy(corners.data(), values.data(), values.size());
    meshopt_encodeIndexVersion(1);  // the extension's
    result.resize(meshopt_encodeIndexBufferBound(corners.size(), corners.size()));
    result.resize(meshopt_encodeIndexBuffer(result.data(), result.size(), corners.data(), corners.size()));
    return result;
  }
  meshopt_encodeVertexVersion(0);
  result.resize(meshopt_encodeVertexBufferBound(count, stride));
  if (packing == GltfPacking::grid) {
    const std::vector<std::uint32_t> grid = on_grid(values);
    result.resize(meshopt_encodeVertexBuffer(result.data(), result.size(), grid.data(), count, stride));
  } else {
    result.resize(meshopt_encodeVertexBuffer(result.data(), result.size(), values.data(), count, stride));
  }
  return result;
}

}  // namespace

std::size_t GltfBuilder::append(std::span<const std::byte> bytes) {
  std::vector<unsigned char>& buffer = buffers_.back();
  buffer.resize((buffer.size() + 3) / 4 * 4);  // glTF wants what accessors refer to aligned to its component
  const std::size_t at = buffer.size();
  buffer.resize(at + bytes.size());
  if (!bytes.empty()) std::memcpy(&buffer[at], bytes.data(), bytes.size());
  return at;
}

int GltfBuilder::add_view(std::span<const std::byte> bytes, int target) {
  const std::size_t at = append(bytes);
  json view = {{"buffer", buffers_.size() - 1}, {"byteOffset", at}, {"byteLength", bytes.size()}};
  if (target != 0) view["target"] = target;
  document_["bufferViews"].push_back(std::move(view));
  return static_cast<int>(document_["bufferViews"].size()) - 1;
}

int GltfBuilder::add_compressed_view(std::span<const std::byte> values, std::size_t stride, GltfPacking packing,
                                     int target) {
  const std::vector<unsigned char> bytes = coded(values, stride, packing);
  const std::size_t at = append(std::as_bytes(std::span(bytes)));
  decoded_bytes_ = (decoded_bytes_ + 3) / 4 * 4;
  json compression = {
      {"buffer", buffers_.size() - 1},   {"byteOffset", at},
      {"byteLength", bytes.size()},      {"byteStride", stride},
      {"count", values.size() / stride}, {"mode", packing == GltfPacking::triangles ? "TRIANGLES" : "ATTRIBUTES"}};
  if (packing == GltfPacking::grid) compression["filter"] = "EXPONENTIAL";
  json view = {{"buffer", kFallback},
               {"byteOffset", decoded_bytes_},
               {"byteLength", values.size()},
               {"extensions", {{kMeshoptExtension, std::move(compression)}}}};
  if (target == kGltfVertices) view["byteStride"] = stride;
  if (target != 0) view["target"] = target;
  decoded_bytes_ += values.size();
  document_["bufferViews"].push_back(std::move(view));
  return static_cast<int>(document_["bufferViews"].size()) - 1;
}

int GltfBuilder::add_accessor(std::span<const std::byte> values, const GltfElement& element, GltfPacking packing,
                              int target) {
  const std::size_t size = element_bytes(element);
  const bool compressed = compresses_ && packing != GltfPacking::none && !values.empty();
  document_["accessors"].push_back(
      {{"bufferView", compressed ? add_compressed_view(values, size, packing, target) : add_view(values, target)},
       {"componentType", element.component},
       {"count", values.size() / size},
       {"type", element.type}});
  return static_cast<int>(document_["accessors"].size()) - 1;
}

int GltfBuilder::add_image(std::span<const std::uint8_t> file, const std::string& mime_type) {
  document_["images"].push_back({{"bufferView", add_view(std::as_bytes(file), 0)}, {"mimeType", mime_type}});
  return static_cast<int>(document_["images"].size()) - 1;
}

int GltfBuilder::add_image_file(const std::string& uri) {
  document_["images"].push_back({{"uri", uri}});
  return static_cast<int>(document_["images"].size()) - 1;
}

std::vector<std::vector<unsigned char>> GltfBuilder::finish(std::span<const std::string> uris) {
  json buffers = json::array();
  for (std::size_t i = 0; i < buffers_.size(); ++i) {
    buffers.push_back({{"byteLength", buffers_[i].size()}});
    if (!uris[i].empty()) buffers.back()["uri"] = uris[i];
  }
  if (decoded_bytes_ > 0) {
    for (json& view : document_["bufferViews"]) {
      if (view["buffer"] == kFallback) view["buffer"] = buffers.size();
    }
    buffers.push_back({{"byteLength", decoded_bytes_}, {"extensions", {{kMeshoptExtension, {{"fallback", true}}}}}});
    document_["extensionsUsed"].push_back(kMeshoptExtension);
    document_["extensionsRequired"].push_back(kMeshoptExtension);
  }
  document_["buffers"] = std::move(buffers);
  return std::move(buffers_);
}

}  // namespace lumatlas
