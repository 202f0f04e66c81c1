// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a glTF 2.0 file, .gltf or .glb, with its buffer, and its parts with every check that a hostile
// file needs.
//
// No file outside the .gltf file's own folder is opened, whatever its URIs say and wherever symbolic links in it lead.
// Every refusal is an InputError of one line that names the file.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "atlas/model/gltf/field_reader.h"
#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/meshopt_compression.h"
#include "atlas/model/gltf/tiny_gltf.h"

namespace lumatlas {

// The type of an accessor's elements, and the number of them that make one value.
struct AccessorType {
  int component;  // TINYGLTF_COMPONENT_TYPE_...
  int type;       // TINYGLTF_TYPE_...
  std::size_t elements_per_value = 1;
};

// The values of an accessor of any type and layout, not yet converted.
struct GltfElements {
  const unsigned char* first;
  std::size_t count;
  std::size_t stride;  // bytes from one element to the next
  int component;       // TINYGLTF_COMPONENT_TYPE_...
  int components;      // per element
  bool normalized;     // integers stand for [0, 1], signed ones for [-1, 1]
};

// Extensions that a file may require: those of a model, or all that leave triangles where they are.
enum class GltfUse { model, mesh };

class GltfFile : public FieldReader {
 public:
  explicit GltfFile(std::filesystem::path file, GltfUse use = GltfUse::model);  // which must be a file

  [[nodiscard]] const Object& extension(const char* name) const;                   // refuses if there is none
  [[nodiscard]] const tinygltf::Primitive& triangles(std::size_t mesh = 0) const;  // the first primitive of the mesh
  [[nodiscard]] int attribute(const char* name, std::size_t mesh = 0) const;  // the accessor's number, for triangles()

  [[nodiscard]] const tinygltf::Model& contents() const { return model_; }  // with no check but of what is read below
  [[nodiscard]] std::uint64_t buffer_bytes() const;
  [[nodiscard]] std::uint64_t decoded_size() const;  // bytes of all compressed buffer views, once decoded

  // A copy of an accessor's values. T is as large as the elements of one value.
  template <typename T>
  [[nodiscard]] std::vector<T> values(int accessor, const std::string& what, const AccessorType& type) const {
    const Bytes bytes = bytes_of(accessor, what, type, sizeof(T));
    std::vector<T> values(bytes.values);
    if (bytes.values > 0) std::memcpy(values.data(), bytes.first, bytes.values * sizeof(T));
    return values;
  }

  // The elements of any accessor that is not sparse, all inside its buffer; they live as long as this object.
  [[nodiscard]] GltfElements elements(int accessor, const std::string& what) const;

  // Returns the URIs of its images and buffers in files of their own.
  [[nodiscard]] std::vector<std::string> uris() const;
  [[nodiscard]] GltfImage image(std::uint32_t index) const;  // its bytes live as long as this object

 private:
  struct Bytes {
    const unsigned char* first;
    std::size_t values;
  };
  [[nodiscard]] Bytes bytes_of(int accessor, const std::string& what, const AccessorType& type,
                               std::size_t value_size) const;
  [[nodiscard]] const tinygltf::Accessor& accessor_at(int accessor, const std::string& where) const;
  [[nodiscard]] const tinygltf::BufferView& view_at(int view, const std::string& where) const;
  [[nodiscard]] std::span<const unsigned char> view_bytes(int view, const std::string& what) const;
  [[nodiscard]] std::span<const unsigned char> packed_bytes(int view, const std::string& what,
                                                            std::size_t element_bytes) const;
  void parse(const GlbFrame& frame, GltfUse use);
  void take_images(nlohmann::json& document);
  void decode_views(const std::set<int>& empty_buffers);
  [[nodiscard]] MeshoptView meshopt_view(const Object& compression, const std::string& where) const;
  [[nodiscard]] std::vector<unsigned char> decoded_bytes(const Object& compression, const MeshoptView& shape,
                                                         const std::string& where) const;
  [[nodiscard]] std::span<const unsigned char> part_of_buffer(int buffer, std::size_t offset, std::size_t length,
                                                              const std::string& where) const;
  void check_required(const nlohmann::json& document, GltfUse use) const;
  void check_version() const;

  // tinygltf is not given the images: it would look for them before their places have been checked.
  struct ImagePlace {
    std::string uri;
    int buffer_view = -1;  // -1: at the URI
  };

  std::vector<ImagePlace> images_;
  tinygltf::Model model_;
  std::map<int, std::vector<unsigned char>> decoded_;  // the bytes of compressed buffer views, by their number
};

}  // namespace lumatlas
