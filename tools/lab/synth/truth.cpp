// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/truth.h"

#include <glm/gtc/quaternion.hpp>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/strict_json.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/lenses/undistortion.h"

namespace lumatlas {

namespace {

using nlohmann::json;

json read_disturbances(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(path.string() + ": cannot be read, make the scene with `lumatlas synth` and a known error, " +
                     "--pose-noise 1 for example");
  }
  return read_json(path);
}

Camera placed(const ColmapImage& image, const ColmapCamera& lens, const glm::dvec3& offset) {
  Camera camera = pinhole_view(lens.lens);
  camera.cam_from_world_rotation = glm::mat3_cast(image.cam_from_world_rotation);
  camera.cam_from_world_translation = image.cam_from_world_translation + camera.cam_from_world_rotation * offset;
  return camera;
}

}  // namespace

std::map<std::string, TrueView> read_synthetic_truth(const std::filesystem::path& scene, const glm::dvec3& offset) {
  const std::filesystem::path folder = scene / "truth";
  const std::filesystem::path described = folder / "disturbances.json";
  const json disturbances = read_disturbances(described);
  const ColmapModel model = read_colmap_model(folder);
  std::map<std::string, TrueView> views;
  for (const ColmapImage& image : model.images) {
    TrueView view;
    view.camera = placed(image, model.camera_of(image), offset);
    try {
      const json& entry = disturbances.at("views").at(image.name);
      const json& gain = entry.at("gain");
      view.gain = {gain.at(0).get<double>(), gain.at(1).get<double>(), gain.at(2).get<double>()};
      view.wrong = entry.at("wrong").get<bool>();
    } catch (const json::exception& error) {
      throw InputError(described.string() + ": view " + image.name + " is not described: " + error.what());
    }
    const std::filesystem::path mask = folder / "masks" / image.name;
    if (std::filesystem::exists(mask)) view.mask = mask;
    views.emplace(image.name, std::move(view));
  }
  return views;
}

}  // namespace lumatlas
