// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the tileset.json of a model's folder, and the files that it names, with every check that a
// hostile file needs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "atlas/model/gltf/field_reader.h"

namespace lumatlas {

class TilesetFile : public FieldReader {
 public:
  explicit TilesetFile(std::filesystem::path file);

  [[nodiscard]] const Object& lumigraph() const;  // refuses if there is none
  // Returns the contents of the tiles without children, which are the root or its children; refuses two of one file.
  [[nodiscard]] std::vector<std::filesystem::path> surfaces() const;
  [[nodiscard]] std::optional<std::filesystem::path> coarse() const;  // the content of a root with children, if any
  [[nodiscard]] std::vector<std::string> uris() const;  // of all tiles and images, as file_beside() takes them
  [[nodiscard]] GltfImage image(std::uint32_t index) const;
  [[nodiscard]] const std::string& json() const { return json_; }

 private:
  [[nodiscard]] const Object& root() const;
  // Returns the tiles without children.
  [[nodiscard]] std::vector<const Object*> chunks() const;
  [[nodiscard]] bool has_coarse() const;
  [[nodiscard]] std::string content_uri(const Object& tile) const;

  std::string json_;
  Object document_;
};

}  // namespace lumatlas
