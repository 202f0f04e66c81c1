// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/live_surface.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/cell_growth.h"
#include "mesh/cells/split_faces.h"
#include "tools/live/kept_depths.h"
#include "tools/live/surface_bend.h"
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
constexpr double kFarthestVertex = 1e10;                     // scene units
constexpr double kSettled = 0.02;                            // voxels that what a frame sees may be off
constexpr double kWorthBending = 0.25;                       // voxels that what a frame sees must have moved
constexpr std::size_t kMostBending = 300, kMostStill = 100;  // frames that a surface is bent by, and held back by
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

// Returns a camera in the grid of the volume.
Camera in_grid(Camera camera) {
  camera.cam_from_world_rotation *= glm::transpose(grid_from_scene());
  return camera;
}

// Returns the image that is fused: the same for the same depths and camera, to the bit.
DepthImage in_grid(const Camera& camera, const RoundedDepth& depth) {
  DepthImage image = slanted_depth(camera, depths_of(depth));
  image.camera = in_grid(camera);
  return image;
}

bool all_within(std::span<const glm::vec3> positions, double distance) {
  return std::all_of(positions.begin(), positions.end(), [&](const glm::vec3& position) {
    const glm::dvec3 off = glm::abs(glm::dvec3(position));
    return off.x < distance && off.y < distance && off.z < distance;
  });
}

void turn_to_scene(TriangleSoup& soup) {
  const glm::dmat3 scene_from_grid = glm::transpose(grid_from_scene());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, soup.positions.size(), 1 << 14), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) soup.positions[i] = scene_from_grid * soup.positions[i];
  });
}

// Appends for each position of a piece that replaced another the one there at the same place, one to one.
void append_previous(const TriangleSoup& before, std::uint32_t first, const TriangleSoup& now,
                     std::vector<VertexId>& previous) {
  const auto by_place = [](const TriangleSoup& soup) {
    std::vector<std::uint32_t> order(soup.positions.size());
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
      const glm::dvec3 &p = soup.positions[a], &q = soup.positions[b];
      return std::tie(p.x, p.y, p.z) < std::tie(q.x, q.y, q.z);
    });
    return order;
  };
  const std::size_t start = previous.size();
  previous.resize(start + now.positions.size(), VertexId::none);
  const std::vector<std::uint32_t> old_order = by_place(before);
  auto old_vertex = old_order.begin();
  for (const std::uint32_t vertex : by_place(now)) {
    const glm::dvec3& place = now.positions[vertex];
    const auto is_before = [&](const glm::dvec3& p) {
      return std::tie(p.x, p.y, p.z) < std::tie(place.x, place.y, place.z);
    };
    while (old_vertex != old_order.end() && is_before(before.positions[*old_vertex])) ++old_vertex;
    if (old_vertex == old_order.end()) break;
    if (before.positions[*old_vertex] == place) previous[start + vertex] = VertexId(first + *old_vertex++);
  }
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
    auto glance = std::make_shared<const DepthGlance>(depth_glance(image.camera, rounded));
    Frame frame{image.camera, image.camera, image.camera, *number, std::move(glance)};
    frames_.insert_or_assign(name, std::move(frame));
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

// Returns how far what a camera sees moves with it, scene units: by its move, and by its turn at the usual distance.
double LiveSurface::movement(const Camera& from, const Camera& to) const {
  const glm::dmat3 turn = to.cam_from_world_rotation * glm::transpose(from.cam_from_world_rotation) - glm::dmat3(1);
  double squares = 0;  // 8 times the squared sine of half the angle
  for (int column = 0; column < 3; ++column) squares += glm::dot(turn[column], turn[column]);
  return glm::distance(to.center(), from.center()) + usual_distance_ * std::sqrt(squares / 2);
}

bool LiveSurface::has_doubles() const {
  return std::any_of(moved_.begin(), moved_.end(), [&](const std::string& name) {
    const Frame& frame = frames_.at(name);
    return movement(frame.fused, frame.wanted) > voxel_;
  });
}

// A frame that has hardly moved stays as it is shown until more has come together, and one out of all bounds stays.
bool LiveSurface::bends(const Frame& frame) const {
  const glm::dvec3 center = glm::abs(frame.wanted.center());
  const bool is_near = center.x < kFarthestVertex && center.y < kFarthestVertex && center.z < kFarthestVertex;
  return is_near && movement(frame.shown, frame.wanted) >= kWorthBending * voxel_;
}

// Returns frames in the order in which they came: of many evenly chosen ones, most of them such that have moved.
std::vector<BendingFrame> LiveSurface::bending_frames() const {
  std::vector<const Frame*> frames;
  frames.reserve(frames_.size());
  for (const auto& [name, frame] : frames_) frames.push_back(&frame);
  std::sort(frames.begin(), frames.end(), [](const Frame* a, const Frame* b) { return a->kept < b->kept; });
  const auto still = std::stable_partition(frames.begin(), frames.end(), [&](const Frame* f) { return bends(*f); });
  std::vector<BendingFrame> chosen;
  const auto choose = [&](std::span<const Frame* const> from, std::size_t most, bool moves) {
    const std::size_t count = std::min(from.size(), most);
    for (std::size_t i = 0; i < count; ++i) {
      const Frame& frame = *from[i * from.size() / count];
      chosen.push_back({frame.shown, moves ? frame.wanted : frame.shown, frame.glance.get()});
    }
  };
  choose({frames.begin(), still}, kMostBending, true);
  if (!chosen.empty()) choose({still, frames.end()}, kMostStill, false);
  return chosen;
}

std::optional<GrownSurface> LiveSurface::bend() {
  if (!fusion_ || !last_) return std::nullopt;
  GrowingTimes times;
  auto start = std::chrono::steady_clock::now();
  std::vector<glm::vec3> positions =
      bent_positions(last_->mesh, last_->cells, bending_frames(), kTruncationVoxels * voxel_, kSettled * voxel_);
  if (positions == last_->mesh.positions || !all_within(positions, kFarthestVertex)) return std::nullopt;
  auto surface = std::make_shared<Surface>(*last_);
  surface->mesh.positions = std::move(positions);
  times.cutting = lap_ms(start);
  surface->cells = measure_cells(surface->mesh, last_->cells.cell_of_face, last_->cells.size);
  times.cells = lap_ms(start);
  std::shared_ptr<const Visibility> visibility = visibility_->of(surface->mesh);
  times.tree = lap_ms(start);
  const std::size_t cells = surface->cells.cells.size();
  std::vector<CellId> same(cells);
  for (CellId cell{0}; cell < cells; ++cell) same[cell] = cell;
  for (auto& [name, frame] : frames_) {
    if (bends(frame)) frame.shown = frame.wanted;
  }
  repair_follows_ = false;  // its faces are where they were before
  last_ = surface;
  return GrownSurface{std::move(surface), std::move(visibility), std::move(same), std::vector<std::uint8_t>(cells, 1),
                      times};
}

bool LiveSurface::follow_move() {
  const auto farthest = [&] {
    const auto off = [&](const std::string& name) { return movement(frames_.at(name).fused, frames_.at(name).wanted); };
    return std::max_element(moved_.begin(), moved_.end(),
                            [&](const std::string& a, const std::string& b) { return off(a) < off(b); });
  }();
  if (farthest == moved_.end()) return false;
  const auto entry = frames_.find(*farthest);
  Frame& frame = entry->second;
  if (movement(frame.fused, frame.wanted) < kSettled * voxel_) {
    moved_.clear();
    return false;
  }
  moved_.erase(farthest);
  DepthImage image = in_grid(frame.fused, kept_->image(frame.kept));
  fusion_->remove(image);
  frame.fused = frame.wanted;
  image.camera = in_grid(frame.fused);  // its slants are those of before, because they are the camera's
  bool added = false;
  try {
    added = fusion_->add(image);
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
    return;
  }
  Piece& entry = pieces_[id];
  std::swap(entry.soup, piece);
  if (entry.first_vertex && !entry.before) entry.before = std::move(piece);
}

TriangleSoup LiveSurface::joined_pieces() const {
  TriangleSoup all;
  for (const auto& [id, piece] : pieces_) {
    const auto first = static_cast<std::uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), piece.soup.positions.begin(), piece.soup.positions.end());
    for (const glm::uvec3& face : piece.soup.faces) all.faces.push_back(face + first);
  }
  return all;
}

// Returns the join of the pieces, which is the next version.
GrownSoup LiveSurface::grown_pieces() {
  GrownSoup grown;
  grown.soup = joined_pieces();
  grown.previous_face.reserve(grown.soup.faces.size());
  std::uint32_t first = 0;
  for (auto& [id, piece] : pieces_) {
    const std::size_t count = piece.soup.positions.size();
    const bool stays = piece.first_vertex && !piece.before;
    const auto first_face = static_cast<std::uint32_t>(grown.previous_face.size());
    for (std::uint32_t i = 0; i < piece.soup.faces.size(); ++i) {
      grown.previous_face.push_back(stays ? FaceId(piece.first_face + i) : FaceId::none);
    }
    piece.first_face = first_face;
    if (!piece.first_vertex) {
      grown.previous_position.resize(first + count, VertexId::none);
    } else if (piece.before) {
      append_previous(*piece.before, *piece.first_vertex, piece.soup, grown.previous_position);
    } else {
      for (std::uint32_t i = 0; i < count; ++i) grown.previous_position.emplace_back(*piece.first_vertex + i);
    }
    piece.before.reset();
    piece.first_vertex = first;
    first += static_cast<std::uint32_t>(count);
  }
  return grown;
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

GrownMesh LiveSurface::joined_mesh(bool follows, GrowingTimes& times) {
  auto start = std::chrono::steady_clock::now();
  GrownSoup grown = grown_pieces();
  if (!follows) {
    grown.previous_position.clear();
    grown.previous_face.clear();
  }
  times.cutting = lap_ms(start);
  GrownMesh made = of_pieces([&] {
    GrownMesh whole = repair_.next(std::move(grown));
    refuse_too_large(whole.mesh);
    Mesh split = split_large_faces(whole.mesh, options_.cell_size);
    const bool has_splits = split.faces.size() != whole.mesh.faces.size();
    whole.mesh = std::move(split);
    if (!follows || has_splits || last_has_splits_) whole.previous_face.clear();
    last_has_splits_ = has_splits;
    return whole;
  });
  times.repairing = lap_ms(start);
  return made;
}

void LiveSurface::refuse_too_large(const Mesh& mesh) const {
  const double faces = fewest_split_faces(mesh, options_.cell_size);
  if (faces <= static_cast<double>(options_.max_piece_faces)) return;
  std::ostringstream why;
  why << "the pieces of surface are too large for cells of " << options_.cell_size << " units: they would become "
      << faces << " faces or more, and may be " << options_.max_piece_faces;
  throw InputError(why.str());
}

std::optional<GrownMesh> LiveSurface::fused_mesh(GrowingFusion::Show show, bool follows, GrowingTimes& times) {
  auto start = std::chrono::steady_clock::now();
  GrownSoup grown = fusion_->grown_surface(show, kFewestFaces);
  if (!follows) {
    grown.previous_position.clear();
    grown.previous_face.clear();
  }
  if (grown.soup.faces.empty()) return std::nullopt;
  turn_to_scene(grown.soup);
  times.cutting = lap_ms(start);
  GrownMesh made = repair_.next(std::move(grown));
  if (!follows) made.previous_face.clear();
  times.repairing = lap_ms(start);
  return made;
}

std::optional<GrownSurface> LiveSurface::grow(GrowingFusion::Show show) {
  if (usual_distance_ == 0 || (!fusion_ && pieces_.empty())) return std::nullopt;
  GrowingTimes times;
  // Until this version is done, the next one cannot follow it.
  const bool follows = std::exchange(repair_follows_, false);
  std::optional<GrownMesh> made = fusion_ ? fused_mesh(show, follows, times) : joined_mesh(follows, times);
  if (!made) return std::nullopt;
  auto surface = std::make_shared<Surface>();
  surface->mesh = std::move(made->mesh);
  auto start = std::chrono::steady_clock::now();
  surface->offset = options_.offset;
  CellOptions cells;
  cells.size = options_.cell_size;
  const Surface nothing;
  const Surface& before = last_ ? *last_ : nothing;
  const std::vector<FaceId> matches =
      made->previous_face.empty() ? match_faces(before.mesh, surface->mesh) : std::move(made->previous_face);
  times.matching = lap_ms(start);
  CellGrowth growth = grow_cells(before.mesh, before.cells, surface->mesh, matches, cells);
  surface->cells = std::move(growth.cells);
  last_ = surface;
  repair_follows_ = true;
  for (auto& [name, frame] : frames_) frame.shown = frame.fused;
  times.cells = lap_ms(start);
  std::shared_ptr<const Visibility> visibility = visibility_->of(surface->mesh);
  times.tree = lap_ms(start);
  return GrownSurface{std::move(surface), std::move(visibility), std::move(growth.previous_cell),
                      std::move(growth.changed), times};
}

}  // namespace lumatlas
