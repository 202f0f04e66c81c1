// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/photograph_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tools/stereo/scene_stereo.h"
#include "tools/stereo/stereo_points.h"

namespace lumatlas {
namespace {

// Returns at most `most` of the ranks, at even distances.
std::vector<std::size_t> evenly(const std::vector<std::size_t>& ranks, std::size_t most) {
  if (ranks.size() <= most) return ranks;
  std::vector<std::size_t> some;
  some.reserve(most);
  for (std::size_t i = 0; i < most; ++i) some.push_back(ranks[i * ranks.size() / most]);
  return some;
}

std::vector<std::size_t> ranks_to_match(const SceneViews& scene, const SceneMeshOptions& options) {
  return evenly(split(scene, options.hold_out).input, options.most_photographs);
}

// Standard deviation of a structure-from-motion point, in pixels of the nearest view that saw it.
constexpr double kPointPixels = 3;

void add_points_of_scene(const ScenePoints& sparse, const std::vector<SceneView>& views, ScenePoints& points) {
  for (std::size_t i = 0; i < sparse.positions.size(); ++i) {
    double width = std::numeric_limits<double>::infinity();
    for (const std::uint32_t view : sparse.views[i]) {
      const Camera& camera = views[view].camera;
      width = std::min(width, glm::distance(camera.center(), sparse.positions[i]) / std::max(camera.fx, camera.fy));
    }
    const auto deviation = static_cast<float>(kPointPixels * width);
    if (!(deviation > 0 && std::isfinite(deviation))) continue;  // a point without views, or at a camera's centre
    points.positions.push_back(sparse.positions[i]);
    points.deviations.push_back(deviation);
    points.views.push_back(sparse.views[i]);
  }
}

// Returns options.block_px, or the least larger size at which all photographs together have at most kSquaresPerPoint
// squares for each of options.most_points.
std::uint32_t block_px_of(const SceneStereo& stereo, const SceneMeshOptions& options) {
  constexpr std::size_t kSquaresPerPoint = 16;  // most squares have no depth, or one that another photograph has
  std::uint32_t block_px = options.block_px;
  const auto squares = [&] {
    std::size_t sum = 0;
    for (std::size_t view = 0; view < stereo.views().size(); ++view) {
      const Camera camera = stereo.camera(view);
      sum += std::size_t{camera.width} * camera.height / (std::size_t{block_px} * block_px);
    }
    return sum;
  };
  while (squares() > kSquaresPerPoint * options.most_points) ++block_px;
  return block_px;
}

}  // namespace

SceneMesh mesh_from_photographs(SceneViews scene, ScenePoints points, const SceneMeshOptions& options,
                                const StageProgress& progress, const std::function<void(const SceneStereo&)>& matched) {
  const std::vector<std::size_t> ranks = ranks_to_match(scene, options);
  if (ranks.size() < 2) {
    throw InputError(scene.root.string() + ": there must be two photographs or more to take depths from, there are " +
                     std::to_string(ranks.size()) + (options.hold_out ? " beside those held out" : ""));
  }
  std::vector<SceneView> views;
  views.reserve(ranks.size());
  for (const std::size_t rank : ranks) views.push_back(scene.views[rank]);
  const ScenePoints sparse = points_of_views(std::move(points), ranks);
  SceneStereo stereo(views, sparse, options.stereo, options.stereo_folder);
  stereo.match(progress(kMatchingStage, stereo.steps()));
  if (matched) matched(stereo);
  StereoPoints found = stereo_points(stereo, block_px_of(stereo, options), progress("joining depths", views.size()));
  ScenePoints all{scene.root, std::move(found.positions), {}, {}, std::move(found.views), std::move(found.deviations)};
  add_points_of_scene(sparse, views, all);
  for (std::vector<std::uint32_t>& seen_by : all.views) {
    for (std::uint32_t& view : seen_by) view = static_cast<std::uint32_t>(ranks[view]);
  }
  if (all.positions.empty()) {
    throw InputError(scene.root.string() + ": its " + std::to_string(views.size()) +
                     " photographs show too little of the same to take depths from");
  }
  SceneMesh made = mesh_from_points(std::move(all), scene, options, progress);
  made.source = MeshSource::photographs;
  made.matched = views.size();
  return made;
}

}  // namespace lumatlas
