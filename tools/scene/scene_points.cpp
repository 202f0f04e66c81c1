// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/scene_points.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "mesh/finite.h"
#include "mesh/ply_reader.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/forms/colmap.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

glm::vec3 unit_or_zero(const glm::vec3& normal) {
  const glm::dvec3 wide(normal);
  const double length = glm::length(wide);
  return std::isfinite(length) && length > 0 ? glm::vec3(wide / length) : glm::vec3(0);
}

ScenePoints points_of_ply(const fs::path& file) {
  const PointSoup soup = parse_ply_points(read_whole_file(file), file.string());
  ScenePoints points{file, {}, {}, {}, {}};
  for (std::size_t i = 0; i < soup.positions.size(); ++i) {
    if (!is_finite(soup.positions[i])) continue;
    points.positions.push_back(soup.positions[i]);
    if (!soup.colors.empty()) points.colors.push_back(soup.colors[i]);
    if (!soup.normals.empty()) points.normals.push_back(unit_or_zero(soup.normals[i]));
  }
  if (points.positions.empty()) throw InputError(file.string() + ": none of its vertices is finite");
  points.views.resize(points.positions.size());
  return points;
}

std::optional<fs::path> dense_points_in(const fs::path& scene) {
  for (const char* const folder : {"", "dense", "dense/0"}) {
    std::error_code ignored;
    fs::path candidate = scene / folder / "fused.ply";
    if (fs::is_regular_file(candidate, ignored)) return candidate;
  }
  return std::nullopt;
}

ScenePoints points_of_model(const ColmapModel& model) {
  std::unordered_map<std::uint32_t, std::uint32_t> rank_of_id;
  for (std::size_t rank = 0; rank < model.images.size(); ++rank) {
    rank_of_id.emplace(model.images[rank].id, static_cast<std::uint32_t>(rank));
  }
  ScenePoints points{points_path(model), {}, {}, {}, {}};
  for (const ColmapPoint& point : read_colmap_points(model)) {
    std::vector<std::uint32_t> ranks;
    for (const std::uint32_t id : point.images) {
      const auto found = rank_of_id.find(id);
      if (found == rank_of_id.end()) {
        throw InputError(points.file.string() + ": the point at index " + std::to_string(points.positions.size()) +
                         " was seen by image " + std::to_string(id) + ", which is not in " +
                         model.images_path.filename().string() + ": the two files are of different models");
      }
      ranks.push_back(found->second);
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    points.positions.push_back(point.position);
    points.colors.push_back(point.color);
    points.views.push_back(std::move(ranks));
  }
  return points;
}

ScenePoints points_of_form(const fs::path& scene, const CaptureForm& form) {
  const std::optional<fs::path> points = form.read(scene, std::nullopt).points;
  if (points) return points_of_ply(scene / *points);
  throw InputError(form.file.string() + ": names no points: name a PLY of points with --points");
}

}  // namespace

ScenePoints read_scene_points(const fs::path& scene, const std::optional<fs::path>& given) {
  if (given) return points_of_ply(*given);
  if (const std::optional<fs::path> dense = dense_points_in(scene)) return points_of_ply(*dense);
  const std::vector<CaptureForm> forms = forms_in(scene);
  if (!forms.empty() && forms.front().read) return points_of_form(scene, forms.front());
  ScenePoints points = points_of_model(read_colmap_model(scene));
  if (points.positions.empty()) throw InputError(points.file.string() + ": holds no point");
  return points;
}

std::optional<ScenePoints> find_scene_points(const fs::path& scene, const std::optional<fs::path>& given) {
  if (given) return read_scene_points(scene, given);
  std::error_code ignored;
  const std::vector<CaptureForm> forms = forms_in(scene);
  if (!forms.empty() && forms.front().read) {
    const std::optional<fs::path> file = forms.front().read(scene, std::nullopt).points;
    const bool exists = file && fs::exists(scene / *file, ignored);
    return exists ? std::optional(points_of_ply(scene / *file)) : std::nullopt;
  }
  const ColmapModel model = read_colmap_model(scene);
  if (!fs::exists(points_path(model), ignored)) return std::nullopt;
  ScenePoints points = points_of_model(model);
  return points.positions.empty() ? std::nullopt : std::optional(std::move(points));
}

bool has_dense_points(const fs::path& scene) {
  return dense_points_in(scene).has_value();
}

}  // namespace lumatlas
