// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/glm.hpp>
#include <stdexcept>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/cell_growth.h"
#include "mesh/repair/repair.h"
#include "tools/live/kept_depths.h"
#include "tools/meshing/cut/small_pieces.h"
#include "tools/meshing/depth/scene_depth.h"

namespace lumatlas {

namespace {

constexpr double kTruncationVoxels = 4;  // as much as mesh_from_depths() takes
constexpr double kCellsPerDistance = 16;
constexpr double kCubeSide = 0.25;        // of a part of the visibility, in distances that most is seen from
constexpr std::size_t kFewestFaces = 60;  // fewest faces of a piece that is not taken for noise
// The weight of a voxel that has a value: a glance aslant from as far away as most depths are.
constexpr double kGlance = 0.05;
constexpr double kMostDepths = 0.9;
constexpr double kStepsPerVoxel = 64;
constexpr double kSettled = 0.02;  // voxels that what a frame sees may be off

std::vector<double> measured_depths(const DepthImage& image) {
  constexpr std::size_t kEvery = 7;  // pixels
  std::vector<double> depths;
  for (std::size_t pixel = 0; pixel < image.depth.size(); pixel += kEvery) {
    if (image.depth[pixel] > 0) depths.push_back(image.depth[pixel]);
  }
  return depths;
}

constexpr Requirement live_surface_requires{"live surface"};

// Returns the image that is fused, in the grid of the volume: the same for the same depths and camera, to the bit.
DepthImage in_grid(const Camera& camera, const RoundedDepth& depth) {
  DepthImage image = slanted_depth(camera, depths_of(depth));
  image.camera.cam_from_world_rotation *= glm::transpose(grid_from_scene());
  return image;
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
  kept_ = std::make_unique<KeptDepths>(
      options.scratch_folder.empty() ? std::filesystem::temp_directory_path() : options.scratch_folder,
      options.kept_memory, options.kept_bytes);
}

LiveSurface::~LiveSurface() = default;

void LiveSurface::start(const DepthImage& image) {
  std::vector<double> depths = measured_depths(image);
  if (depths.empty()) return;
  usual_distance_ = upper_median(depths);
  const double far = percentile(depths, kMostDepths);
  FusionOptions fusion;
  voxel_ = options_.voxel.value_or(kLiveVoxelPixels * usual_distance_ / image.camera.fx);
  fusion.voxel = voxel_;
  fusion.truncation = kTruncationVoxels * fusion.voxel;
  fusion.least_weight = kGlance / (far * far);
  fusion.max_blocks = options_.max_blocks;
  if (options_.cell_size == 0) options_.cell_size = usual_distance_ / kCellsPerDistance;
  fusion_ = std::make_unique<GrowingFusion>(fusion);
  visibility_ = std::make_unique<GrowingVisibility>(kCubeSide * usual_distance_);
}

bool LiveSurface::add(const DepthImage& image, const std::string& name) {
  check(image);
  if (!fusion_) start(image);
  if (!fusion_) return false;
  const RoundedDepth rounded = rounded_depth(image.depth, voxel_ / kStepsPerVoxel);
  if (std::all_of(rounded.steps.begin(), rounded.steps.end(), [](std::uint16_t steps) { return steps == 0; })) {
    return false;
  }
  if (!fusion_->add(in_grid(image.camera, rounded))) return false;
  if (name.empty()) return true;
  if (const std::optional<std::size_t> number = kept_->keep(rounded)) {
    frames_.insert_or_assign(name, Frame{image.camera, image.camera, *number});
  }
  return true;
}

void LiveSurface::move(const std::string& name, const Camera& camera) {
  const auto frame = frames_.find(name);
  if (frame == frames_.end()) return;
  frame->second.wanted.cam_from_world_rotation = camera.cam_from_world_rotation;
  frame->second.wanted.cam_from_world_translation = camera.cam_from_world_translation;
  moved_.insert(name);
}

// Returns how far what the frame sees moves, scene units: by the move of the camera, and by its turn at the usual
// distance.
double LiveSurface::movement(const Frame& frame) const {
  const glm::dmat3 turn =
      frame.wanted.cam_from_world_rotation * glm::transpose(frame.fused.cam_from_world_rotation) - glm::dmat3(1);
  double squares = 0;  // 8 times the squared sine of half the angle
  for (int column = 0; column < 3; ++column) squares += glm::dot(turn[column], turn[column]);
  return glm::distance(frame.wanted.center(), frame.fused.center()) + usual_distance_ * std::sqrt(squares / 2);
}

bool LiveSurface::follow_move() {
  const auto farthest = [&] {
    return std::max_element(moved_.begin(), moved_.end(), [&](const std::string& a, const std::string& b) {
      return movement(frames_.at(a)) < movement(frames_.at(b));
    });
  }();
  if (farthest == moved_.end()) return false;
  const auto entry = frames_.find(*farthest);
  Frame& frame = entry->second;
  if (movement(frame) < kSettled * voxel_) {
    moved_.clear();
    return false;
  }
  moved_.erase(farthest);
  const RoundedDepth depth = kept_->image(frame.kept);
  fusion_->remove(in_grid(frame.fused, depth));
  frame.fused = frame.wanted;
  bool added = false;
  try {
    added = fusion_->add(in_grid(frame.fused, depth));
  } catch (const std::invalid_argument&) {  // its pose is too far from the others
  }
  if (!added) frames_.erase(entry);
  return true;
}

std::optional<GrownSurface> LiveSurface::grow(GrowingFusion::Show show) {
  if (!fusion_) return std::nullopt;
  GrowingTimes times;
  auto start = std::chrono::steady_clock::now();
  const auto lap = [&](double& ms) {
    const auto now = std::chrono::steady_clock::now();
    ms = std::chrono::duration<double, std::milli>(now - std::exchange(start, now)).count();
  };
  TriangleSoup soup = fusion_->surface(show);
  (void)remove_small_pieces(soup, kFewestFaces);
  if (soup.faces.empty()) return std::nullopt;
  turn_to_scene(soup);
  lap(times.cutting);
  auto surface = std::make_shared<Surface>();
  surface->mesh = repair(soup, glm::dvec3(0)).mesh;
  lap(times.repairing);
  surface->offset = options_.offset;
  CellOptions cells;
  cells.size = options_.cell_size;
  const Surface nothing;
  const Surface& before = last_ ? *last_ : nothing;
  const std::vector<FaceId> matches = match_faces(before.mesh, surface->mesh);
  lap(times.matching);
  CellGrowth growth = grow_cells(before.mesh, before.cells, surface->mesh, matches, cells);
  surface->cells = std::move(growth.cells);
  last_ = surface;
  lap(times.cells);
  std::shared_ptr<const Visibility> visibility = visibility_->of(surface->mesh);
  lap(times.tree);
  return GrownSurface{std::move(surface), std::move(visibility), std::move(growth.previous_cell),
                      std::move(growth.changed), times};
}

}  // namespace lumatlas
