// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/photographs/photograph_lookup.h"

#include <map>
#include <memory>
#include <string>
#include <system_error>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

}  // namespace

namespace {

std::optional<ImageSize> some_size_in(const fs::path& folder) {
  for (const std::string& name : pictures_in(folder)) {
    try {
      return photograph_size(folder / name, Orientation::as_stored);
    } catch (const InputError&) {  // the next one may be whole
    }
  }
  return std::nullopt;
}

}  // namespace

std::function<ImageSize(const PosedPhotograph&)> sizes_in(const fs::path& scene,
                                                          const std::optional<fs::path>& images) {
  const auto sizes_of_folders = std::make_shared<std::map<fs::path, std::optional<ImageSize>>>();
  return [=](const PosedPhotograph& photograph) {
    const fs::path file = images ? *images / photograph.name : scene / photograph.file;
    try {
      return photograph_size(file, Orientation::as_stored);
    } catch (const InputError&) {
      const auto [entry, is_new] = sizes_of_folders->try_emplace(file.parent_path());
      if (is_new) entry->second = some_size_in(entry->first);
      if (!entry->second) throw;
      return *entry->second;
    }
  };
}

PhotographLookup photographs_of(const CaptureRequest& request) {
  const fs::path& scene = request.scene;
  const std::optional<fs::path>& images = request.images;
  std::error_code ignored;
  const fs::path below = fs::is_directory(scene / "images", ignored) ? "images" : "";
  const fs::path folder = images.value_or(scene / below);
  const auto names = std::make_shared<const PhotographNames>(pictures_in(folder));
  PhotographLookup lookup;
  lookup.find = [=](std::string_view label) {
    const std::string name = names->find_by_path(label);
    if (!inner_path(name)) throw InputError("the photograph " + in_quotes(label) + " is no path to a file");
    PosedPhotograph photograph{name};
    photograph.file = below / photograph.name;
    return photograph;
  };
  lookup.size_of = sizes_in(scene, images);
  lookup.bad = request.bad;
  return lookup;
}

}  // namespace lumatlas
