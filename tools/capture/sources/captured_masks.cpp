// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/sources/captured_masks.h"

#include <nlohmann/json.hpp>

#include "mesh/base/errors.h"
#include "tools/capture/step_record.h"
#include "tools/capture/work_folder.h"
#include "tools/scene/scene_list.h"

namespace lumatlas {

namespace fs = std::filesystem;

fs::path folder_of_masks(const std::optional<fs::path>& given) {
  if (!given) return {};
  std::error_code error;
  fs::path folder = fs::canonical(*given, error);
  if (error || !fs::is_directory(folder, error)) throw InputError(given->string() + ": no such folder of masks");
  return folder;
}

std::map<std::string, fs::path> masks_by_photograph(const fs::path& folder, const CapturedPhotographs& captured) {
  std::map<std::string, fs::path> masks;
  if (folder.empty()) return masks;
  const std::vector<std::string> names = names_of(captured);
  for (const std::string& name : names) {
    SceneView view;
    view.name = name;
    if (const std::optional<fs::path> mask = mask_of(view, folder)) masks.emplace(name, *mask);
  }
  if (!masks.empty()) return masks;
  const std::string first = names.empty() ? "NAME.jpg" : names.front();
  throw InputError(folder.string() + ": has a mask of none of the " + std::to_string(names.size()) +
                   " photographs; that of " + first + " would be " + first + ".png");
}

nlohmann::json states_of_masks(const std::map<std::string, fs::path>& masks) {
  nlohmann::json states;
  for (const auto& [name, mask] : masks) states[name] = {{"file", mask.string()}, {"state", file_state(mask)}};
  return states;
}

fs::path link_masks_for_colmap(const std::map<std::string, fs::path>& masks, const fs::path& folder) {
  remove_all_of(folder);
  if (masks.empty()) return {};
  for (const auto& [name, mask] : masks) {
    const fs::path link = folder / (name + ".png");
    fs::create_directories(link.parent_path());
    put_link(link, mask);
  }
  return folder;
}

}  // namespace lumatlas
