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
#include "mesh/readers/ply_reader.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/forms/colmap/colmap.h"

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

// Returns true if a point that the image saw may be in this photograph. An image that is a panorama is six photographs,
// of which one or more look towards the point.
bool looks_towards(const PosedPhotograph& photograph, const glm::dvec3& point) {
  const glm::dvec3 cam = photograph.cam_from_world_rotation * point + photograph.cam_from_world_translation;
  return !photograph.panorama || cam.z >= std::max(std::abs(cam.x), std::abs(cam.y));
}

ScenePoints points_of_model(const ColmapModel& model, const std::vector<PosedPhotograph>& photographs) {
  std::unordered_multimap<std::uint32_t, std::uint32_t> ranks_of_id;
  for (std::size_t rank = 0; rank < photographs.size(); ++rank) {
    ranks_of_id.emplace(photographs[rank].id, static_cast<std::uint32_t>(rank));
  }
  ScenePoints points{points_path(model), {}, {}, {}, {}};
  for (const ColmapPoint& point : read_colmap_points(model)) {
    std::vector<std::uint32_t> ranks;
    for (const std::uint32_t id : point.images) {
      const auto [first, last] = ranks_of_id.equal_range(id);
      if (first == last) {
        throw InputError(points.file.string() + ": the point at index " + std::to_string(points.positions.size()) +
                         " was seen by image " + std::to_string(id) + ", which is not in " +
                         model.images_path.filename().string() + ": the two files are of different models");
      }
      for (auto found = first; found != last; ++found) {
        if (looks_towards(photographs[found->second], point.position)) ranks.push_back(found->second);
      }
    }
    std::sort(ranks.begin(), ranks.end());
    ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
    points.positions.push_back(point.position);
    points.colors.push_back(point.color);
    points.views.push_back(std::move(ranks));
  }
  return points;
}

// Those that came with the poses; none if there are none.
std::optional<ScenePoints> points_of_capture(const fs::path& scene, const Capture& capture) {
  std::error_code ignored;
  if (capture.form != "COLMAP") {
    const bool exists = capture.points && fs::exists(scene / *capture.points, ignored);
    return exists ? std::optional(points_of_ply(scene / *capture.points)) : std::nullopt;
  }
  const ColmapModel model = read_colmap_model(scene);
  if (!fs::exists(points_path(model), ignored)) return std::nullopt;
  ScenePoints points = points_of_model(model, capture.photographs);
  return points.positions.empty() ? std::nullopt : std::optional(std::move(points));
}

}  // namespace

ScenePoints read_scene_points(const fs::path& scene, const std::optional<fs::path>& given) {
  if (given) return points_of_ply(*given);
  if (const std::optional<fs::path> dense = dense_points_in(scene)) return points_of_ply(*dense);
  const Capture capture = read_capture({scene});
  if (std::optional<ScenePoints> points = points_of_capture(scene, capture)) return *std::move(points);
  throw InputError(capture.file.string() + ": comes with no points: name a PLY of points with --points");
}

std::optional<ScenePoints> find_scene_points(const fs::path& scene, const std::optional<fs::path>& given) {
  return given ? read_scene_points(scene, given) : points_of_capture(scene, read_capture({scene}));
}

bool has_dense_points(const fs::path& scene) {
  return dense_points_in(scene).has_value();
}

}  // namespace lumatlas
