// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/scene_facts.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <vector>

#include "atlas/tiles/tiles.h"
#include "blend/gpu_bytes.h"
#include "mesh/base/errors.h"
#include "mesh/scene_extent.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

constexpr const char* kSceneFolder = "=scene/";

std::optional<std::size_t> whole_number(const OptionValues& options, const char* name) {
  const auto found = options.find(name);
  if (found == options.end() || !found->second.given || !found->second.text) return std::nullopt;
  const std::string& text = *found->second.text;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

[[noreturn]] void refuse(const std::string& name, const std::string& text) {
  throw InputError((is_setting(name) ? "" : "--") + name + " is \"" + text +
                   "\", must be =scene/FILE, or =diameter, =photographs, =offered, =texels or =bytes, if need be with "
                   "/ or * and a positive number");
}

// "60" of "diameter/60" as 1/60; 1 if there is nothing.
double factor(const std::string& name, const std::string& text, std::size_t from) {
  if (from == std::string::npos) return 1;
  const char* const end = text.data() + text.size();
  double number = 0;
  const auto [stop, error] = std::from_chars(text.data() + from + 1, end, number);
  if (error != std::errc() || stop != end || !std::isfinite(number) || !(number > 0)) refuse(name, text);
  return text[from] == '/' ? 1 / number : number;
}

std::string whole(double number) {
  return std::to_string(std::max(1LL, std::llround(number)));
}

std::string in_scene(const std::string& text, const std::filesystem::path& scene) {
  return (scene / text.substr(std::string_view(kSceneFolder).size())).string();
}

std::string quantity_text(const std::string& name, const std::string& text, const SceneFacts& facts) {
  const std::size_t sign = text.find_first_of("*/");
  const std::string quantity = text.substr(1, sign == std::string::npos ? sign : sign - 1);
  const double times = factor(name, text, sign);
  if (quantity == "diameter") return nlohmann::json(facts.diameter * times).dump();
  if (quantity == "photographs") return whole(static_cast<double>(facts.photographs) * times);
  if (quantity == "offered") return whole(static_cast<double>(facts.offered) * times);
  if (quantity == "texels") return whole(facts.texels * times) + "texels";
  if (quantity == "bytes") return whole(facts.bytes * times);
  refuse(name, text);
}

}  // namespace

SceneFacts scene_facts(const std::filesystem::path& scene, const OptionValues& build) {
  const auto mesh_option = build.find("mesh");
  std::optional<std::filesystem::path> mesh;
  if (mesh_option != build.end() && mesh_option->second.given && mesh_option->second.text) {
    const std::string& text = *mesh_option->second.text;
    mesh = text.starts_with(kSceneFolder) ? in_scene(text, scene) : text;
  }
  const SurfaceInput input = load_surface(scene, mesh, CellOptions{});
  const SceneViews views = read_scene_views(scene, input.surface->offset);
  SceneFacts facts;
  facts.diameter = scene_diameter(input.surface->mesh);
  facts.photographs = views.views.size();
  std::vector<std::size_t> offered(views.views.size());
  std::iota(offered.begin(), offered.end(), std::size_t{0});
  if (const auto hold = whole_number(build, "hold")) {
    offered = split(views.views.size(), {*hold, whole_number(build, "block").value_or(1)}).input;
  }
  facts.offered = offered.size();
  double tiles = 0;
  const TileOptions layout;
  for (const std::size_t rank : offered) {
    const Camera& camera = views.views[rank].camera;
    facts.texels += static_cast<double>(camera.width) * camera.height;
    tiles += static_cast<double>(TileGrid(camera.width, camera.height, layout.tile_px).tiles());
  }
  double held = 1;
  if (const auto most = whole_number(build, "max-views"); most && *most < facts.offered) {
    held = static_cast<double>(*most) / static_cast<double>(facts.offered);
  }
  facts.texels *= held;
  facts.bytes = held * tiles * static_cast<double>(place_bytes(layout)) +
                static_cast<double>(GpuByteCount(input.surface).of_surface());
  return facts;
}

OptionValues resolved(OptionValues options, const std::filesystem::path& scene,
                      const std::function<SceneFacts()>& facts) {
  for (auto& [name, value] : options) {
    if (!value.given || !value.text || !value.text->starts_with('=')) continue;
    const std::string text = *value.text;
    value.text = text.starts_with(kSceneFolder) ? in_scene(text, scene) : quantity_text(name, text, facts());
  }
  return options;
}

}  // namespace lumatlas
