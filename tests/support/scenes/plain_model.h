// SPDX-License-Identifier: GPL-3.0-or-later
// Files of a model's folder by their names without content: "images/00001.png" for images/00001-93c1ff0b7aa21e04.png.
#pragma once

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "tests/support/temporary_folder.h"

namespace lumatlas {

// A text with names of files in it, all of which lose their content.
inline std::string without_content(const std::string& text) {
  static const std::regex content("-[0-9a-f]{16}(\\.(png|jpg|bin|glb|json))");
  return std::regex_replace(text, content, "$1");
}

// The files that differ from their names without content, by these.
inline std::map<std::string, std::filesystem::path> files_named_by_content(const std::filesystem::path& folder) {
  std::map<std::string, std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().lexically_relative(folder).string();
    if (without_content(name) != name) files.emplace(without_content(name), entry.path());
  }
  return files;
}

// Returns the path of the model's file; if there is none of the name, a path that does not exist.
inline std::filesystem::path file_of_model(const std::filesystem::path& folder, const std::string& name) {
  const auto files = files_named_by_content(folder);
  const auto found = files.find(name);
  return found == files.end() ? folder / name : found->second;
}

// Renames the files of a model in a folder to their names without content; but the surface's, whose JSON names others.
inline void give_plain_names(const std::filesystem::path& folder) {
  for (const auto& [name, file] : files_named_by_content(folder)) {
    if (!name.ends_with(".glb")) std::filesystem::rename(file, folder / name);
  }
}

// The JSON of a .glb.
inline nlohmann::json glb_json(const std::filesystem::path& file) {
  const std::string bytes = bytes_of(file);
  std::uint32_t length = 0;
  std::memcpy(&length, &bytes.at(12), sizeof length);
  return nlohmann::json::parse(bytes.substr(20, length));
}

// The JSON of a model's surface in a folder.
inline nlohmann::json surface_json(const std::filesystem::path& folder) {
  return glb_json(file_of_model(folder, "surface.glb"));
}

// The properties of a model in a folder: those of its tileset, and those of its surface.
inline nlohmann::json lumigraph_of(const std::filesystem::path& folder) {
  nlohmann::json properties = surface_json(folder).at("extensions").at("LUMATLAS_lumigraph");
  properties.update(nlohmann::json::parse(bytes_of(folder / "tileset.json")).at("extensions").at("LUMATLAS_lumigraph"));
  return properties;
}

// Makes of a model in a folder one glTF file, scene.gltf, with its buffer, scene.bin, and images with names without
// content. What only a page shows is left out: masks, thumbnails and the poster.
inline void make_one_gltf(const std::filesystem::path& folder) {
  using nlohmann::json;
  json document = surface_json(folder);
  json properties = lumigraph_of(folder);
  const std::string glb = bytes_of(file_of_model(folder, "surface.glb"));
  std::uint32_t length = 0;
  std::memcpy(&length, &glb.at(12), sizeof length);
  std::ofstream(folder / "scene.bin", std::ios::binary)
      << glb.substr(28 + length, document["buffers"][0]["byteLength"].get<std::size_t>());
  document["buffers"][0]["uri"] = "scene.bin";
  json images = json::array();
  const auto add = [&](json image) {
    image = {{"uri", without_content(image["uri"].get<std::string>())}};
    images.push_back(std::move(image));
    return images.size() - 1;
  };
  for (json& view : properties["views"]) {
    for (const char* kind : {"image", "lensMask", "trustMask"}) {
      if (view.contains(kind)) view[kind] = add(properties["images"][view[kind].get<std::size_t>()]);
    }
    for (const char* kind : {"mask", "thumbnail"}) view.erase(kind);
  }
  if (properties["views"].is_null()) properties.erase("views");
  if (document.contains("textures")) document["textures"][0]["source"] = add(document["images"][0]);
  for (const char* name : {"images", "poster"}) properties.erase(name);
  document["images"] = std::move(images);
  document["extensions"]["LUMATLAS_lumigraph"] = std::move(properties);
  give_plain_names(folder);
  std::ofstream(folder / "scene.gltf", std::ios::binary) << document.dump();
  std::filesystem::remove(folder / "tileset.json");
  std::filesystem::remove(file_of_model(folder, "surface.glb"));
}

}  // namespace lumatlas
