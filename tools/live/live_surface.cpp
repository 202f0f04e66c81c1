// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/cell_growth.h"
#include "mesh/repair/repair.h"
#include "tools/meshing/cut/small_pieces.h"

namespace lumatlas {

namespace {

constexpr double kTruncationVoxels = 4;  // as much as mesh_from_depths() takes
constexpr double kCellsPerDistance = 16;
constexpr std::size_t kFewestFaces = 60;  // fewest faces of a piece that is not taken for noise
// The weight of a voxel that has a value: a glance aslant from as far away as most depths are.
constexpr double kGlance = 0.05;
constexpr double kMostDepths = 0.9;

std::vector<double> measured_depths(const DepthImage& image) {
  constexpr std::size_t kEvery = 7;  // pixels
  std::vector<double> depths;
  for (std::size_t pixel = 0; pixel < image.depth.size(); pixel += kEvery) {
    if (image.depth[pixel] > 0) depths.push_back(image.depth[pixel]);
  }
  return depths;
}

constexpr Requirement live_surface_requires{"live surface"};

DepthImage in_grid(const DepthImage& image) {
  DepthImage turned = image;
  turned.camera.cam_from_world_rotation *= glm::transpose(grid_from_scene());
  return turned;
}

void turn_to_scene(TriangleSoup& soup) {
  const glm::dmat3 scene_from_grid = glm::transpose(grid_from_scene());
  for (glm::dvec3& position : soup.positions) position = scene_from_grid * position;
}

}  // namespace

void check(const LiveSurfaceOptions& options) {
  const double voxel = options.voxel.value_or(1);
  live_surface_requires(std::isfinite(voxel) && voxel > 0, "voxel", voxel, "finite and above 0");
  live_surface_requires(std::isfinite(options.cell_size) && options.cell_size >= 0, "cell_size", options.cell_size,
                        "finite and not negative");
  live_surface_requires(options.max_blocks >= 1, "max_blocks", 0, "at least 1");
}

LiveSurface::LiveSurface(const LiveSurfaceOptions& options) : options_(options) {
  check(options);
}

LiveSurface::~LiveSurface() = default;

void LiveSurface::start(const DepthImage& image) {
  std::vector<double> depths = measured_depths(image);
  if (depths.empty()) return;
  usual_distance_ = upper_median(depths);
  const double far = percentile(depths, kMostDepths);
  FusionOptions fusion;
  fusion.voxel = options_.voxel.value_or(kLiveVoxelPixels * usual_distance_ / image.camera.fx);
  fusion.truncation = kTruncationVoxels * fusion.voxel;
  fusion.least_weight = kGlance / (far * far);
  fusion.max_blocks = options_.max_blocks;
  if (options_.cell_size == 0) options_.cell_size = usual_distance_ / kCellsPerDistance;
  fusion_ = std::make_unique<GrowingFusion>(fusion);
}

bool LiveSurface::add(const DepthImage& image) {
  if (!fusion_) start(image);
  return fusion_ && fusion_->add(in_grid(image));
}

std::optional<GrownSurface> LiveSurface::grow(GrowingFusion::Show show) {
  if (!fusion_) return std::nullopt;
  TriangleSoup soup = fusion_->surface(show);
  (void)remove_small_pieces(soup, kFewestFaces);
  if (soup.faces.empty()) return std::nullopt;
  turn_to_scene(soup);
  auto surface = std::make_shared<Surface>();
  surface->mesh = repair(soup, glm::dvec3(0)).mesh;
  surface->offset = options_.offset;
  CellOptions cells;
  cells.size = options_.cell_size;
  const Surface nothing;
  const Surface& before = last_ ? *last_ : nothing;
  CellGrowth growth =
      grow_cells(before.mesh, before.cells, surface->mesh, match_faces(before.mesh, surface->mesh), cells);
  surface->cells = std::move(growth.cells);
  last_ = surface;
  std::shared_ptr<const Visibility> visibility = make_ray_visibility(surface->mesh);
  return GrownSurface{std::move(surface), std::move(visibility), std::move(growth.previous_cell),
                      std::move(growth.changed)};
}

}  // namespace lumatlas
