// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/glm.hpp>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/cell_growth.h"
#include "mesh/cells/split_faces.h"
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
constexpr double kFarthestVertex = 1e10;       // scene units
constexpr double kSettled = 0.02;              // voxels that what a frame sees may be off
constexpr std::uint32_t kLookedAtPixels = 64;  // sides of the pictures that the usual distance is found by

// Returns the time since `start`, which becomes now; milliseconds.
double lap_ms(std::chrono::steady_clock::time_point& start) {
  const auto now = std::chrono::steady_clock::now();
  return std::chrono::duration<double, std::milli>(now - std::exchange(start, now)).count();
}

std::vector<double> measured_depths(const DepthImage& image) {
  constexpr std::size_t kEvery = 7;  // pixels
  std::vector<double> depths;
  for (std::size_t pixel = 0; pixel < image.depth.size(); pixel += kEvery) {
    if (image.depth[pixel] > 0) depths.push_back(image.depth[pixel]);
  }
  return depths;
}

constexpr Requirement live_surface_requires{"live surface"};

// Runs a step that makes a surface of pieces. Turns std::invalid_argument into InputError: the pieces are at fault, and
// not the program.
template <typename Run>
auto of_pieces(const Run& run) {
  try {
    return run();
  } catch (const std::invalid_argument& error) {
    throw InputError(std::string("the pieces of surface cannot be used: ") + error.what());
  }
}

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
  live_surface_requires(options.max_piece_faces >= 1, "max_piece_faces", 0, "at least 1");
}

void check_piece(const TriangleSoup& piece) {
  if (!piece.colors.empty()) throw std::invalid_argument("live surface: a piece has colours");
  for (const glm::dvec3& position : piece.positions) {
    const glm::dvec3 off = glm::abs(position);
    if (!(off.x < kFarthestVertex && off.y < kFarthestVertex && off.z < kFarthestVertex))
      throw std::invalid_argument("live surface: a piece has a vertex that is not finite or too far from the origin");
  }
  for (const glm::uvec3& face : piece.faces) {
    if (std::max({face.x, face.y, face.z}) >= piece.positions.size())
      throw std::invalid_argument("live surface: a piece has a face that refers to no vertex");
  }
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
  set_distance(upper_median(depths));
  const double far = percentile(depths, kMostDepths);
  FusionOptions fusion;
  voxel_ = options_.voxel.value_or(kLiveVoxelPixels * usual_distance_ / image.camera.fx);
  fusion.voxel = voxel_;
  fusion.truncation = kTruncationVoxels * fusion.voxel;
  fusion.least_weight = kGlance / (far * far);
  fusion.max_blocks = options_.max_blocks;
  fusion_ = std::make_unique<GrowingFusion>(fusion);
}

void LiveSurface::set_distance(double distance) {
  usual_distance_ = distance;
  if (options_.cell_size == 0) options_.cell_size = usual_distance_ / kCellsPerDistance;
  visibility_ = std::make_unique<GrowingVisibility>(kCubeSide * usual_distance_);
}

bool LiveSurface::add(const DepthImage& image, const std::string& name) {
  check(image);
  if (has_pieces_) throw std::logic_error("live surface: a depth frame comes after pieces of surface");
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

void LiveSurface::replace_piece(std::uint32_t id, TriangleSoup piece) {
  if (fusion_) throw std::logic_error("live surface: a piece of surface comes after depth frames");
  check_piece(piece);
  has_pieces_ = true;
  if (piece.faces.empty()) {
    pieces_.erase(id);
  } else {
    pieces_.insert_or_assign(id, std::move(piece));
  }
}

TriangleSoup LiveSurface::joined_pieces() const {
  TriangleSoup all;
  for (const auto& [id, piece] : pieces_) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), piece.positions.begin(), piece.positions.end());
    for (const glm::uvec3& face : piece.faces) all.faces.push_back(face + first);
  }
  return all;
}

bool LiveSurface::find_distance(std::span<const Camera> cameras) {
  if (pieces_.empty() || cameras.empty()) return false;
  Mesh mesh;
  const TriangleSoup all = joined_pieces();
  mesh.positions.assign(all.positions.begin(), all.positions.end());
  mesh.faces = all.faces;
  const std::unique_ptr<Visibility> visibility = of_pieces([&] { return make_ray_visibility(mesh); });
  std::vector<double> depths;
  for (const Camera& camera : cameras) {
    for (const float depth : visibility->trace(camera.shrunk_to(kLookedAtPixels)).depth) {
      if (std::isfinite(depth)) depths.push_back(depth);
    }
  }
  if (depths.empty()) return false;
  set_distance(upper_median(depths));
  return true;
}

void LiveSurface::guess_distance() {
  const Bounds box = bounds(joined_pieces());
  const double diagonal = box.empty() ? 0 : glm::distance(box.min, box.max);
  set_distance(diagonal > 0 ? diagonal / 2 : 1);
}

std::optional<Mesh> LiveSurface::joined_mesh(GrowingTimes& times) const {
  auto start = std::chrono::steady_clock::now();
  const TriangleSoup soup = joined_pieces();
  times.cutting = lap_ms(start);
  Mesh mesh = of_pieces([&] {
    Mesh whole = repair(soup, glm::dvec3(0)).mesh;
    refuse_too_large(whole);
    return split_large_faces(whole, options_.cell_size);
  });
  times.repairing = lap_ms(start);
  return mesh;
}

void LiveSurface::refuse_too_large(const Mesh& mesh) const {
  const double faces = fewest_split_faces(mesh, options_.cell_size);
  if (faces <= static_cast<double>(options_.max_piece_faces)) return;
  std::ostringstream why;
  why << "the pieces of surface are too large for cells of " << options_.cell_size << " units: they would become "
      << faces << " faces or more, and may be " << options_.max_piece_faces;
  throw InputError(why.str());
}

std::optional<Mesh> LiveSurface::fused_mesh(GrowingFusion::Show show, GrowingTimes& times) {
  auto start = std::chrono::steady_clock::now();
  TriangleSoup soup = fusion_->surface(show);
  (void)remove_small_pieces(soup, kFewestFaces);
  if (soup.faces.empty()) return std::nullopt;
  turn_to_scene(soup);
  times.cutting = lap_ms(start);
  Mesh mesh = repair(soup, glm::dvec3(0)).mesh;
  times.repairing = lap_ms(start);
  return mesh;
}

std::optional<GrownSurface> LiveSurface::grow(GrowingFusion::Show show) {
  if (usual_distance_ == 0 || (!fusion_ && pieces_.empty())) return std::nullopt;
  GrowingTimes times;
  std::optional<Mesh> mesh = fusion_ ? fused_mesh(show, times) : joined_mesh(times);
  if (!mesh) return std::nullopt;
  auto surface = std::make_shared<Surface>();
  surface->mesh = std::move(*mesh);
  auto start = std::chrono::steady_clock::now();
  surface->offset = options_.offset;
  CellOptions cells;
  cells.size = options_.cell_size;
  const Surface nothing;
  const Surface& before = last_ ? *last_ : nothing;
  const std::vector<FaceId> matches = match_faces(before.mesh, surface->mesh);
  times.matching = lap_ms(start);
  CellGrowth growth = grow_cells(before.mesh, before.cells, surface->mesh, matches, cells);
  surface->cells = std::move(growth.cells);
  last_ = surface;
  times.cells = lap_ms(start);
  std::shared_ptr<const Visibility> visibility = visibility_->of(surface->mesh);
  times.tree = lap_ms(start);
  return GrownSurface{std::move(surface), std::move(visibility), std::move(growth.previous_cell),
                      std::move(growth.changed), times};
}

}  // namespace lumatlas
