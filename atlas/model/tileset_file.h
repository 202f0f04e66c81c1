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

// The views of a model and their images, in a file beside its tileset.
class ViewFile : public FieldReader {
 public:
  explicit ViewFile(std::filesystem::path file);
  [[nodiscard]] const Object& lists() const { return document_; }

 private:
  Object document_;
};

class TilesetFile : public FieldReader {
 public:
  explicit TilesetFile(std::filesystem::path file);

  [[nodiscard]] const Object& lumigraph() const;  // refuses if there is none
  // Returns the contents of the tiles without children, which are the chunks; refuses two of one file.
  [[nodiscard]] std::vector<std::filesystem::path> surfaces() const;
  [[nodiscard]] std::vector<std::filesystem::path> coarse() const;  // the contents of the tiles with children
  [[nodiscard]] std::vector<std::string> uris() const;       // of all tiles and images, as file_beside() takes them
  [[nodiscard]] GltfImage image(std::uint32_t index) const;  // of the properties of the whole
  // The file and the object that list the views and their images: the tileset and its lumigraph(), or a file beside it.
  [[nodiscard]] const FieldReader& view_file() const;
  [[nodiscard]] const Object& view_lists() const;
  [[nodiscard]] GltfImage view_image(std::uint32_t index) const;
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
  [[nodiscard]] std::string view_file_uri() const;  // empty: the tileset lists the views itself

  std::string json_;
  Object document_;
  std::optional<ViewFile> views_;
};

}  // namespace lumatlas
