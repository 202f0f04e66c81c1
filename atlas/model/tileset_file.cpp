// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/tileset_file.h"

#include <nlohmann/json.hpp>
#include <set>

#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/model_extension.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

TilesetFile::TilesetFile(std::filesystem::path file) : FieldReader(std::move(file)) {
  json_ = read_whole_file(path());
  const int levels = nesting(json_);
  if (levels > kMaxNesting) {
    refuse("nests its values " + std::to_string(levels) + " deep, must be at most " + std::to_string(kMaxNesting));
  }
  try {
    document_ = value_of(nlohmann::json::parse(json_));
  } catch (const nlohmann::json::exception& error) {
    refuse("is no JSON that can be read: " + short_reason(error.what()));
  }
  const Object& asset = field(document_, "it", "asset");
  const std::string version = text(asset, "\"asset\"", "version");
  if (!version.starts_with("1.")) {
    refuse("is of 3D Tiles version " + in_quotes(version) + ", this program reads 1.1");
  }
}

const FieldReader::Object& TilesetFile::lumigraph() const {
  if (document_.Has("extensions")) {
    const Object& extensions = document_.Get("extensions");
    if (extensions.IsObject() && extensions.Has(kLumigraphExtension)) return extensions.Get(kLumigraphExtension);
  }
  refuse(std::string("has no extension ") + kLumigraphExtension + ": it is a surface without photographs");
}

const FieldReader::Object& TilesetFile::root() const {
  return field(document_, "it", "root");
}

TilesetFile::Tiles TilesetFile::tiles() const {
  Tiles tiles;
  add_tiles(root(), tiles);
  return tiles;
}

void TilesetFile::add_tiles(const Object& tile, Tiles& tiles) const {
  const bool is_parent = tile.IsObject() && tile.Has("children");
  if (is_parent && !tile.Get("children").IsArray()) refuse("\"children\" is not an array");
  if (!is_parent || tile.Get("children").ArrayLen() == 0) {
    tiles.chunks.push_back(&tile);
    return;
  }
  if (tile.Has("content")) tiles.coarse.push_back(&tile);
  const Object& children = tile.Get("children");
  for (std::size_t i = 0; i < children.ArrayLen(); ++i) add_tiles(children.Get(static_cast<int>(i)), tiles);
}

std::string TilesetFile::content_uri(const Object& tile) const {
  return text(field(tile, "a tile", "content"), "\"content\"", "uri");
}

std::vector<std::filesystem::path> TilesetFile::surfaces() const {
  std::vector<std::filesystem::path> files;
  std::set<std::filesystem::path> known;
  for (const Object* chunk : tiles().chunks) {
    files.push_back(file_beside(content_uri(*chunk), "its surface"));
    if (!known.insert(files.back().lexically_normal()).second) {
      refuse("two tiles have the surface " + files.back().filename().string() + ", each must have its own");
    }
  }
  return files;
}

std::vector<std::filesystem::path> TilesetFile::coarse() const {
  std::vector<std::filesystem::path> files;
  for (const Object* tile : tiles().coarse) files.push_back(file_beside(content_uri(*tile), "a coarse surface"));
  return files;
}

GltfImage TilesetFile::image(std::uint32_t index) const {
  const std::string where = "image " + std::to_string(index);
  const Object& images = field(lumigraph(), kLumigraphExtension, "images");
  if (!images.IsArray()) refuse("\"images\" is not an array");
  if (index >= images.ArrayLen()) refuse(where + " does not exist");
  return {file_beside(text(images.Get(static_cast<int>(index)), where, "uri"), where), {}};
}

std::vector<std::string> TilesetFile::uris() const {
  std::vector<std::string> uris;
  const Tiles all = tiles();
  for (const std::vector<const Object*>& kind : {all.coarse, all.chunks}) {
    for (const Object* tile : kind) uris.push_back(content_uri(*tile));
  }
  if (!lumigraph().Has("images")) return uris;
  const Object& images = lumigraph().Get("images");
  if (!images.IsArray()) refuse("\"images\" is not an array");
  for (std::size_t i = 0; i < images.ArrayLen(); ++i) {
    uris.push_back(text(images.Get(static_cast<int>(i)), "image " + std::to_string(i), "uri"));
  }
  return uris;
}

}  // namespace lumatlas
