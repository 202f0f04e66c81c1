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

  [[nodiscard]] const Object& lumigraph() const;                      // refuses if there is none
  [[nodiscard]] std::filesystem::path surface() const;                // the content of the only tile without children
  [[nodiscard]] std::optional<std::filesystem::path> coarse() const;  // of the root, if it is another one
  [[nodiscard]] std::vector<std::string> uris() const;  // of all tiles and images, as file_beside() takes them
  [[nodiscard]] GltfImage image(std::uint32_t index) const;
  [[nodiscard]] const std::string& json() const { return json_; }

 private:
  // Returns the tiles from the root to the surface's.
  [[nodiscard]] std::vector<const Object*> tiles() const;
  [[nodiscard]] std::string content_uri(const Object& tile) const;

  std::string json_;
  Object document_;
};

}  // namespace lumatlas
