// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a glTF 2.0 document that grows with the values that are put into its buffers, as they are or
// compressed by EXT_meshopt_compression.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace lumatlas {

// The type of an accessor's elements: glTF's number of the component, and the name of the type, such as "VEC3".
struct GltfElement {
  int component;
  const char* type;
};
inline constexpr int kGltfByte = 5121, kGltfShort = 5123, kGltfWhole = 5125, kGltfFloat = 5126;  // all unsigned
inline constexpr int kGltfVertices = 34962, kGltfFaces = 34963;                                  // targets of views

// Compression of an accessor's values, for a builder that compresses.
enum class GltfPacking {
  none,
  attributes,  // elements of a multiple of 4 bytes, at most 256
  grid,        // floats that are whole numbers of at most 24 bits times one power of two
  triangles,   // corners of faces
};

class GltfBuilder {
 public:
  explicit GltfBuilder(bool compresses) : compresses_(compresses) {}

  // Adds an accessor of the values, which are packed one after another, and returns its number. `target` of the buffer
  // view: 0 for none. Any number of T make one element, or any number of elements one T.
  template <typename T>
  int add(const std::vector<T>& values, const GltfElement& element, GltfPacking packing, int target = 0) {
    return add_accessor(std::as_bytes(std::span(values)), element, packing, target);
  }
  // Adds an image of the current buffer, and returns its number.
  int add_image(std::span<const std::uint8_t> file, const std::string& mime_type);
  // Adds an image in a file of its own, and returns its number.
  int add_image_file(const std::string& uri);

  // Begins another buffer, into which all goes that is added from now on.
  void begin_buffer() { buffers_.emplace_back(); }

  [[nodiscard]] nlohmann::json& document() { return document_; }
  [[nodiscard]] nlohmann::json& accessor(int number) {
    return document_["accessors"][static_cast<std::size_t>(number)];
  }
  [[nodiscard]] std::uint64_t bytes() const { return buffers_.back().size(); }  // of the current buffer

  // Writes the list of buffers and extensions into the document and returns the buffers' bytes. `uris`: one for each
  // buffer, empty: it is a .glb's binary chunk. To be called once, as the last.
  std::vector<std::vector<unsigned char>> finish(std::span<const std::string> uris);
  [[nodiscard]] std::span<const std::vector<unsigned char>> buffers() const { return buffers_; }

 private:
  int add_accessor(std::span<const std::byte> values, const GltfElement& element, GltfPacking packing, int target);
  int add_view(std::span<const std::byte> bytes, int target);
  int add_compressed_view(std::span<const std::byte> values, std::size_t stride, GltfPacking packing, int target);
  std::size_t append(std::span<const std::byte> bytes);

  bool compresses_;
  nlohmann::json document_ = {{"asset", {{"version", "2.0"}, {"generator", "lumatlas"}}}};
  std::vector<std::vector<unsigned char>> buffers_{1};
  std::uint64_t decoded_bytes_ = 0;  // of all compressed views
};

}  // namespace lumatlas
