// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/tileset_file.h"

#include <nlohmann/json.hpp>
#include <set>

#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/model_extension.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

FieldReader::Object parsed(const std::string& json, const FieldReader& file) {
  const int levels = nesting(json);
  if (levels > kMaxNesting) {
    file.refuse("nests its values " + std::to_string(levels) + " deep, must be at most " + std::to_string(kMaxNesting));
  }
  try {
    return value_of(nlohmann::json::parse(json));
  } catch (const nlohmann::json::exception& error) {
    file.refuse("is no JSON that can be read: " + short_reason(error.what()));
  }
}

// Returns image `index` of those that an object lists.
GltfImage listed_image(const FieldReader& file, const FieldReader::Object& object, const char* name,
                       std::uint32_t index) {
  const std::string where = "image " + std::to_string(index);
  const FieldReader::Object& images = file.field(object, name, "images");
  if (!images.IsArray()) file.refuse("\"images\" is not an array");
  if (index >= images.ArrayLen()) file.refuse(where + " does not exist");
  return {file.file_beside(file.text(images.Get(static_cast<int>(index)), where, "uri"), where), {}};
}

// Adds the URIs of the images that an object lists, if it does.
void add_image_uris(const FieldReader& file, const FieldReader::Object& object, std::vector<std::string>& uris) {
  if (!object.Has("images")) return;
  const FieldReader::Object& images = object.Get("images");
  if (!images.IsArray()) file.refuse("\"images\" is not an array");
  for (std::size_t i = 0; i < images.ArrayLen(); ++i) {
    uris.push_back(file.text(images.Get(static_cast<int>(i)), "image " + std::to_string(i), "uri"));
  }
}

}  // namespace

ViewFile::ViewFile(std::filesystem::path file) : FieldReader(std::move(file)) {
  document_ = parsed(read_whole_file(path()), *this);
  if (!document_.IsObject()) refuse("is no object that lists \"views\"");
}

TilesetFile::TilesetFile(std::filesystem::path file) : FieldReader(std::move(file)) {
  json_ = read_whole_file(path());
  document_ = parsed(json_, *this);
  const Object& asset = field(document_, "it", "asset");
  const std::string version = text(asset, "\"asset\"", "version");
  if (!version.starts_with("1.")) {
    refuse("is of 3D Tiles version " + in_quotes(version) + ", this program reads 1.1");
  }
  if (const std::string uri = view_file_uri(); !uri.empty()) views_.emplace(file_beside(uri, "the list of its views"));
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
  return listed_image(*this, lumigraph(), kLumigraphExtension, index);
}

const FieldReader& TilesetFile::view_file() const {
  return views_ ? static_cast<const FieldReader&>(*views_) : *this;
}

const FieldReader::Object& TilesetFile::view_lists() const {
  return views_ ? views_->lists() : lumigraph();
}

GltfImage TilesetFile::view_image(std::uint32_t index) const {
  return listed_image(view_file(), view_lists(), views_ ? "it" : kLumigraphExtension, index);
}

// A surface without photographs has none.
std::string TilesetFile::view_file_uri() const {
  if (!document_.Has("extensions")) return {};
  const Object& extensions = document_.Get("extensions");
  if (!extensions.IsObject() || !extensions.Has(kLumigraphExtension)) return {};
  const Object& properties = extensions.Get(kLumigraphExtension);
  if (!properties.IsObject() || !properties.Has("viewFile")) return {};
  std::string uri = text(properties.Get("viewFile"), "\"viewFile\"", "uri");
  if (uri.empty() || std::filesystem::path(uri).has_parent_path()) {
    refuse("\"viewFile\" is " + in_quotes(uri) + ", must be the name of a file beside it");
  }
  return uri;
}

std::vector<std::string> TilesetFile::uris() const {
  std::vector<std::string> uris;
  const Tiles all = tiles();
  for (const std::vector<const Object*>& kind : {all.coarse, all.chunks}) {
    for (const Object* tile : kind) uris.push_back(content_uri(*tile));
  }
  add_image_uris(*this, lumigraph(), uris);
  if (views_) {
    uris.push_back(view_file_uri());
    add_image_uris(*views_, views_->lists(), uris);
  }
  return uris;
}

}  // namespace lumatlas
