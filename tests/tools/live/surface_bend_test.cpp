// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/surface_bend.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

namespace lumatlas {
namespace {

constexpr double kVoxel = 0.05, kReach = 4 * kVoxel, kLeast = 0.02 * kVoxel;
constexpr double kCellSize = 0.25;
constexpr std::uint32_t kSteps = 40;  // of a wall of 2 x 2 units, along each side

// Adds a wall in the plane z = `z`, with x and y from -1 to 1.
void add_wall(double z, Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (std::uint32_t row = 0; row <= kSteps; ++row) {
    for (std::uint32_t column = 0; column <= kSteps; ++column) {
      mesh.positions.emplace_back(2.0 * column / kSteps - 1, 2.0 * row / kSteps - 1, z);
    }
  }
  for (std::uint32_t row = 0; row < kSteps; ++row) {
    for (std::uint32_t column = 0; column < kSteps; ++column) {
      const std::uint32_t corner = first + row * (kSteps + 1) + column;
      mesh.faces.emplace_back(corner, corner + kSteps + 1, corner + 1);
      mesh.faces.emplace_back(corner + 1, corner + kSteps + 1, corner + kSteps + 2);
    }
  }
}

Cells cells_of(const Mesh& mesh) {
  CellOptions options;
  options.size = kCellSize;
  return make_cells(mesh, options);
}

// A frame at z = -2 that looks along z and has measured a plane.
struct PlaneFrame {
  Camera camera = centered_camera(640, 480, 400);
  DepthGlance glance;

  explicit PlaneFrame(double plane, double x = 0) {
    camera.cam_from_world_translation = {-x, 0, 2};
    RoundedDepth depth{0.001, std::vector<std::uint16_t>(std::size_t{640} * 480)};
    depth.steps.assign(depth.steps.size(), static_cast<std::uint16_t>(1000 * (plane + 2)));
    glance = depth_glance(camera, depth);
  }
  [[nodiscard]] BendingFrame moved(const glm::dvec3& shift) const {
    Camera wanted = camera;
    wanted.cam_from_world_translation -= wanted.cam_from_world_rotation * shift;
    return {camera, wanted, &glance};
  }
};

std::vector<glm::vec3> bent(const Mesh& mesh, const std::vector<BendingFrame>& frames) {
  return bent_positions(mesh, cells_of(mesh), frames, kReach, kLeast);
}

// Returns the largest distance of vertices, from `first` to before `last`, from where they were and `shift`.
double farthest_from(const Mesh& before, const std::vector<glm::vec3>& after, const glm::dvec3& shift,
                     std::size_t first, std::size_t last) {
  double farthest = 0;
  for (std::size_t vertex = first; vertex < last; ++vertex) {
    const glm::dvec3 moved = glm::dvec3(after[vertex]) - glm::dvec3(before.positions[vertex]);
    farthest = std::max(farthest, glm::distance(moved, shift));
  }
  return farthest;
}

TEST_CASE("a small copy of a depth image has what the image has in the middle of its pixels") {
  const Camera camera = centered_camera(640, 480, 400);
  RoundedDepth depth{0.5, {}};
  for (std::uint32_t i = 0; i < 640 * 480; ++i) depth.steps.push_back(static_cast<std::uint16_t>(i % 640));
  const DepthGlance glance = depth_glance(camera, depth);
  CHECK(glance.width == 48);
  CHECK(glance.height == 36);
  CHECK(glance.depth.unit == 0.5);
  REQUIRE(glance.depth.steps.size() == std::size_t{48} * 36);
  for (std::uint32_t x = 0; x < 48; ++x) {
    CHECK(std::abs(glance.depth.steps[x] - (x + 0.5) * 640 / 48) <= 1);
    CHECK(glance.depth.steps[35 * 48 + x] == glance.depth.steps[x]);
  }
  // A picture that is smaller already stays as it is.
  const DepthGlance same = depth_glance(centered_camera(3, 2, 2), {0.5, {1, 2, 3, 4, 5, 6}});
  CHECK(same.width == 3);
  CHECK(same.depth.steps == std::vector<std::uint16_t>{1, 2, 3, 4, 5, 6});
}

TEST_CASE("a surface of frames that move alike moves as they do") {
  Mesh mesh;
  add_wall(0, mesh);
  const PlaneFrame a(0), b(0, 0.5);
  const glm::dvec3 shift(0.3, -0.2, 0.1);
  CHECK(farthest_from(mesh, bent(mesh, {a.moved(shift), b.moved(shift)}), shift, 0, mesh.positions.size()) < 1e-6);
  // A turn about the wall's middle, which the frame sees from in front.
  const double angle = 0.1;
  const glm::dmat3 turn(std::cos(angle), std::sin(angle), 0, -std::sin(angle), std::cos(angle), 0, 0, 0, 1);
  BendingFrame turned = a.moved({});
  turned.wanted.cam_from_world_rotation = a.camera.cam_from_world_rotation * glm::transpose(turn);
  const std::vector<glm::vec3> positions = bent(mesh, {turned});
  for (std::size_t vertex = 0; vertex < positions.size(); ++vertex) {
    CHECK(glm::distance(glm::dvec3(positions[vertex]), turn * glm::dvec3(mesh.positions[vertex])) < 1e-6);
  }
}

TEST_CASE("a surface whose frames stay, move too little or have measured nothing of it stays to the bit") {
  Mesh mesh;
  add_wall(0, mesh);
  const PlaneFrame frame(0), elsewhere(0.5);
  CHECK(bent(mesh, {}) == mesh.positions);
  CHECK(bent(mesh, {frame.moved({})}) == mesh.positions);
  CHECK(bent(mesh, {frame.moved({0.9 * kLeast, 0, 0})}) == mesh.positions);
  CHECK(bent(mesh, {elsewhere.moved({1, 0, 0})}) == mesh.positions);
  Camera behind = frame.camera;
  behind.cam_from_world_translation.z = -2;
  BendingFrame of_behind = frame.moved({1, 0, 0});
  of_behind.shown = behind;
  CHECK(bent(mesh, {of_behind}) == mesh.positions);
  CHECK(bent(Mesh{}, {frame.moved({1, 0, 0})}).empty());
}

TEST_CASE("two walls that a drift has left beside each other move each with its own frames") {
  Mesh mesh;
  add_wall(0, mesh);
  const std::size_t walls = mesh.positions.size();
  add_wall(0.4, mesh);
  const PlaneFrame early(0), late(0.4);
  const glm::dvec3 drift(0.05, 0, -0.4);
  const std::vector<glm::vec3> positions = bent(mesh, {early.moved({}), late.moved(drift)});
  CHECK(std::equal(positions.begin(), positions.begin() + static_cast<std::ptrdiff_t>(walls), mesh.positions.begin()));
  CHECK(farthest_from(mesh, positions, drift, walls, 2 * walls) < 1e-6);
}

TEST_CASE("between frames that move differently the surface bends without a step") {
  Mesh mesh;
  add_wall(0, mesh);
  // The one sees the left part of the wall alone, the other the right part.
  const PlaneFrame left(0, -2.2), right(0, 2.2);
  const glm::dvec3 drift(0, 0, 0.3);
  const std::vector<glm::vec3> positions = bent(mesh, {left.moved({}), right.moved(drift)});
  const auto z_at = [&](std::uint32_t column) { return positions[kSteps / 2 * (kSteps + 1) + column].z; };
  CHECK(z_at(0) == 0);
  CHECK(z_at(kSteps) == Approx(0.3));
  float steepest = 0;
  for (std::uint32_t column = 0; column < kSteps; ++column) {
    CHECK(z_at(column + 1) >= z_at(column) - 1e-6F);
    steepest = std::max(steepest, z_at(column + 1) - z_at(column));
  }
  CHECK(steepest < 0.1F);  // over at least a cell, which is five columns
}

TEST_CASE("parts of a surface that no frame has measured move as those beside them") {
  Mesh mesh;
  add_wall(0, mesh);
  PlaneFrame frame(0);
  // Nothing is measured in the lower three quarters of the picture.
  auto& steps = frame.glance.depth.steps;
  std::fill(steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4), steps.end(), std::uint16_t{0});
  const glm::dvec3 shift(0.1, 0.2, 0.3);
  CHECK(farthest_from(mesh, bent(mesh, {frame.moved(shift)}), shift, 0, mesh.positions.size()) < 1e-6);
}

TEST_CASE("a surface bends to the same bytes with any number of threads") {
  Mesh mesh;
  add_wall(0, mesh);
  add_wall(0.4, mesh);
  std::vector<PlaneFrame> seen;
  for (int i = 0; i < 12; ++i) seen.emplace_back(i % 3 == 0 ? 0.4 : 0.0, 0.3 * i - 1.5);
  std::vector<BendingFrame> frames;
  double share = 0;
  for (const PlaneFrame& frame : seen) frames.push_back(frame.moved((share += 0.03) * glm::dvec3(1, -0.5, 0.7)));
  std::vector<glm::vec3> of_one, of_two;
  tbb::task_arena(1).execute([&] { of_one = bent(mesh, frames); });
  tbb::task_arena(2).execute([&] { of_two = bent(mesh, frames); });
  CHECK(of_one == of_two);
  CHECK_FALSE(of_one == mesh.positions);
}

}  // namespace
}  // namespace lumatlas
