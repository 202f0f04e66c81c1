// SPDX-License-Identifier: GPL-3.0-or-later
// Files of a model's folder by their names without content: "images/00001.png" for images/00001-93c1ff0b7aa21e04.png.
#pragma once

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>

#include "tests/support/temporary_folder.h"

namespace lumatlas {

// A text with names of files in it, all of which lose their content.
inline std::string without_content(const std::string& text) {
  static const std::regex content("-[0-9a-f]{16}(\\.(png|jpg|bin))");
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

// Renames the files of a model in a folder to their names without content, as earlier versions wrote them.
inline void give_plain_names(const std::filesystem::path& folder) {
  for (const auto& [name, file] : files_named_by_content(folder)) std::filesystem::rename(file, folder / name);
  const std::string gltf = without_content(bytes_of(folder / "scene.gltf"));
  std::ofstream(folder / "scene.gltf", std::ios::binary) << gltf;
}

}  // namespace lumatlas
