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
  // Returns the contents of the tiles without children, which are the chunks; refuses two of one file.
  [[nodiscard]] std::vector<std::filesystem::path> surfaces() const;
  [[nodiscard]] std::vector<std::filesystem::path> coarse() const;  // the contents of the tiles with children
  [[nodiscard]] std::vector<std::string> uris() const;  // of all tiles and images, as file_beside() takes them
  [[nodiscard]] GltfImage image(std::uint32_t index) const;
  [[nodiscard]] const std::string& json() const { return json_; }

 private:
  [[nodiscard]] const Object& root() const;
  // The tiles in the order in which they are read, a parent before its children.
  struct Tiles {
    std::vector<const Object*> chunks;  // without children
    std::vector<const Object*> coarse;  // with children and content
  };
  [[nodiscard]] Tiles tiles() const;
  void add_tiles(const Object& tile, Tiles& tiles) const;
  [[nodiscard]] std::string content_uri(const Object& tile) const;

  std::string json_;
  Object document_;
};

}  // namespace lumatlas
