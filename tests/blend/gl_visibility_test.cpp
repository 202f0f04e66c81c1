// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl_visibility.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <thread>

#include "blend/renderer.h"
#include "blend/tables/cell_runs.h"
#include "mesh/cells/split_faces.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/surfaces.h"
#include "tests/support/visibility_agreement.h"

namespace lumatlas {
namespace {

// Says so where there is no OpenGL 4.5; any other failure of GL is one of the test.
bool no_gl() {
  return !context_or_skip();
}

Cells cells_of(const Mesh& mesh, std::uint32_t count) {
  std::vector<CellId> cell_of_face(mesh.faces.size());
  for (std::uint32_t face = 0; face < cell_of_face.size(); ++face) cell_of_face[face] = CellId(face % count);
  return measure_cells(mesh, cell_of_face, 1);
}

std::unique_ptr<Visibility> gl_visibility(const Mesh& mesh, const Cells& cells, bool frustum_culling = true) {
  return make_gl_visibility(mesh, cells, {.frustum_culling = frustum_culling, .debug = true});
}
std::unique_ptr<Visibility> gl_visibility(const Mesh& mesh) {
  return gl_visibility(mesh, cells_of(mesh, 1));
}

// At the origin, looking along z, its principal point off the centre.
Camera straight_camera() {
  Camera camera;
  camera.width = 33;
  camera.height = 21;
  camera.fx = 20;
  camera.fy = 22;
  camera.cx = 12;
  camera.cy = 14;
  return camera;
}

Camera placed(Camera camera, const glm::dvec3& center, const glm::dquat& rotation) {
  camera.cam_from_world_rotation = glm::mat3_cast(glm::normalize(rotation));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

Camera random_camera(std::mt19937& random, double spread, std::uint32_t width, std::uint32_t height) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fx = std::max(width, height) * (0.9 + 0.5 * uniform(random));
  camera.fy = camera.fx * (1 + 0.1 * uniform(random));
  camera.cx = width * (0.5 + 0.4 * uniform(random));
  camera.cy = height * (0.5 + 0.4 * uniform(random));
  const glm::dvec3 center = spread * glm::dvec3(uniform(random), uniform(random), uniform(random));
  return placed(camera, center, glm::dquat(uniform(random), uniform(random), uniform(random), uniform(random)));
}

Mesh rectangle(const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
  return {{corner, corner + u, corner + u + v, corner + v}, {}, {{0, 1, 2}, {0, 2, 3}}};
}
// Across the axis, wider than the image.
Mesh wall_at(float z) {
  return rectangle({-9 * z, -9 * z, z}, {18 * z, 0, 0}, {0, 18 * z, 0});
}

Mesh random_triangles(std::uint32_t count, float size, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  Mesh mesh;
  for (std::uint32_t face = 0; face < count; ++face) {
    const glm::vec3 middle(4 * uniform(random), 4 * uniform(random), 4 * uniform(random));
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back(middle + size * glm::vec3(uniform(random), uniform(random), uniform(random)));
    }
    mesh.faces.emplace_back(3 * face, 3 * face + 1, 3 * face + 2);
  }
  return mesh;
}

bool sees_nothing(const VisibilityBuffer& buffer) {
  return std::all_of(buffer.face.begin(), buffer.face.end(), [](std::uint32_t face) { return face == FaceId::none; }) &&
         std::all_of(buffer.depth.begin(), buffer.depth.end(), [](float depth) { return std::isinf(depth); });
}

// In pixels, by how much corners may be off where depth is taken from: see takes_depth_from_exact_corners().
double corner_error() {
  return takes_depth_from_exact_corners(EglContext()) ? 0 : 1.0 / 256;
}

// The surface y = height of the camera frame, which ends at `farthest`, must be all that is seen. Returns the largest
// relative error of its depths as a share of the error that is allowed, or infinity if anything else is seen or a pixel
// of it is not. Allowed is what depth changes over the error of corners, and 5e-5 for floats: the reciprocal of depth
// is interpolated, and beside the horizon it is 140 times smaller than at the image's lower border.
double floor_error(const Camera& camera, const VisibilityBuffer& buffer, double height, double farthest) {
  double worst = 0;
  const double corners = corner_error();
  for (std::size_t pixel = 0; pixel < buffer.depth.size(); ++pixel) {
    const double below_horizon = static_cast<double>(pixel / camera.width) + 0.5 - camera.cy;
    const double depth = height * camera.fy / below_horizon;
    const bool is_floor = depth > 0 && depth < farthest;
    const double seen = static_cast<double>(buffer.depth[pixel]);
    if (is_floor) worst = std::max(worst, std::abs(seen / depth - 1) / (5e-5 + corners / below_horizon));
    if (!is_floor && !std::isinf(seen)) return std::numeric_limits<double>::infinity();
  }
  return worst;
}

double depth_error(const VisibilityBuffer& buffer, double depth) {
  double worst = 0;
  for (const float seen : buffer.depth) worst = std::max(worst, std::abs(static_cast<double>(seen) / depth - 1));
  return worst;
}

bool sees_only(const VisibilityBuffer& buffer, std::uint32_t first_face, std::uint32_t last_face) {
  return std::all_of(buffer.face.begin(), buffer.face.end(),
                     [&](std::uint32_t face) { return face >= first_face && face <= last_face; });
}

constexpr double kSameFaces = 0.999;

TEST_CASE("the GPU's depth is z in the camera frame, from in front and from behind") {
  if (no_gl()) return;
  for (const Mesh& wall : {wall_at(3), turned_inside_out(wall_at(3))}) {
    const VisibilityBuffer buffer = gl_visibility(wall)->trace(straight_camera());
    REQUIRE(buffer.width == 33);
    REQUIRE(buffer.height == 21);
    REQUIRE(buffer.depth.size() == 33 * 21);
    CHECK(depth_error(buffer, 3) < 1e-6);
    CHECK(sees_only(buffer, 0, 1));
  }
}

TEST_CASE("the GPU sees nothing of what is behind the camera or outside of the image") {
  if (no_gl()) return;
  const Camera camera = straight_camera();
  const glm::vec3 x(1, 0, 0);
  const glm::vec3 y(0, 1, 0);
  for (const Mesh& mesh : {turned_inside_out(wall_at(-3)), rectangle({-9, -9, 0}, 18.f * x, 18.f * y),
                           rectangle({40, 0, 3}, x, y), rectangle({0, -40, 3}, x, y)}) {
    CHECK(sees_nothing(gl_visibility(mesh)->trace(camera)));
    CHECK(sees_nothing(gl_visibility(mesh, cells_of(mesh, 1), false)->trace(camera)));
  }
}

TEST_CASE("the GPU samples pixels at their centres, from the top left") {
  if (no_gl()) return;
  // The wall's edges at x = 0 and y = 0 project to the principal point, (12, 14).
  const VisibilityBuffer buffer = gl_visibility(rectangle({0, 0, 2}, {9, 0, 0}, {0, 9, 0}))->trace(straight_camera());
  std::size_t wrong = 0;
  for (std::size_t y = 0; y < 21; ++y) {
    for (std::size_t x = 0; x < 33; ++x) wrong += (buffer.face[33 * y + x] != FaceId::none) != (x >= 12 && y >= 14);
  }
  CHECK(wrong == 0);
}

TEST_CASE("the GPU agrees with rays on random triangles around the camera") {
  if (no_gl()) return;
  const Mesh mesh = random_triangles(300, 1.5f, 5);
  const auto rays = make_ray_visibility(mesh);
  const auto gl = gl_visibility(mesh, cells_of(mesh, 7));
  std::mt19937 random(11);
  VisibilityAgreement agreement;
  VisibilityBuffer buffer;
  for (int i = 0; i < 30; ++i) {
    const Camera camera = random_camera(random, 4, 320, 211);
    gl->trace(camera, buffer);
    compare(rays->trace(camera), buffer, agreement);
  }
  INFO("equal: " << agreement.share_equal() << ", same face: " << agreement.share_same_face()
                 << ", worst depth: " << agreement.worst_depth);
  CHECK(agreement.share_smooth() > 0.5);
  CHECK(agreement.share_equal() >= kSameFaces);
  CHECK(agreement.share_same_face() >= kSameFaces);
  CHECK(agreement.worst_depth < 1e-4 + corner_error());  // many are seen nearly edge-on
}

TEST_CASE("the GPU agrees with rays in a closed room, and no pixel leaks through the edges of its faces") {
  if (no_gl()) return;
  const auto surface = room_surface();
  const auto rays = make_ray_visibility(surface->mesh);
  const auto gl = gl_visibility(surface->mesh, surface->cells);
  VisibilityAgreement agreement;
  for (std::size_t number = 0; number < 40; ++number) {
    const Camera camera = room_camera(number).scaled_to(400, 300);
    const VisibilityBuffer buffer = gl->trace(camera);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), FaceId::none) == 0);
    compare(rays->trace(camera), buffer, agreement);
  }
  INFO("equal: " << agreement.share_equal() << ", same face: " << agreement.share_same_face()
                 << ", worst depth: " << agreement.worst_depth);
  CHECK(agreement.share_smooth() > 0.9);
  CHECK(agreement.share_equal() >= kSameFaces);
  CHECK(agreement.share_same_face() >= kSameFaces);
  CHECK(agreement.worst_depth < 1e-5 + 0.1 * corner_error());
}

TEST_CASE("the GPU agrees with rays on images of any size, and on a surface seen from inside and outside") {
  if (no_gl()) return;
  const Mesh mesh = sphere(5);
  const Cells cells = make_cells(mesh, {.size = 0.3});
  const auto rays = make_ray_visibility(mesh);
  const auto gl = gl_visibility(mesh, cells);
  std::mt19937 random(3);
  VisibilityBuffer buffer;
  for (const auto& [width, height] : {std::pair{1u, 1u}, {7u, 3u}, {1u, 500u}, {2000u, 1u}, {641u, 479u}, {7u, 3u}}) {
    VisibilityAgreement agreement;
    for (int i = 0; i < 12; ++i) {
      const Camera camera = random_camera(random, i % 2 == 0 ? 0.5 : 2.5, width, height);
      gl->trace(camera, buffer);
      compare(rays->trace(camera), buffer, agreement);
    }
    CAPTURE(width, height, agreement.smooth, agreement.differ);
    CHECK(agreement.share_smooth() > 0.3);  // the smallest are mostly silhouette
    // The smallest image has only 12 pixels, and corners are rounded to a 256th of its whole width.
    CHECK(agreement.differ <= std::max<std::size_t>(1, agreement.smooth / 1000));
    CHECK(agreement.share_same_face() >= 0.9);
  }
}

TEST_CASE("the GPU sees a floor that reaches under and behind the camera, however close it is") {
  if (no_gl()) return;
  const Camera camera = straight_camera().scaled_to(330, 210);
  for (const float height : {2.f, 0.1f, 1e-4f}) {
    CAPTURE(height);
    const Mesh floor = split_large_faces(rectangle({-200, height, -100}, {400, 0, 0}, {0, 0, 200}), 4);
    CHECK(floor_error(camera, gl_visibility(floor)->trace(camera), static_cast<double>(height), 100) < 1);
  }
}

TEST_CASE("nothing is too near or too far for the GPU, even both at once") {
  if (no_gl()) return;
  const Camera camera = straight_camera();
  for (const float depth : {1e-6f, 1e-3f, 1.f, 1e6f, 1e15f}) {
    CAPTURE(depth);
    const VisibilityBuffer buffer = gl_visibility(joined(wall_at(1e16f), wall_at(depth)))->trace(camera);
    CHECK(depth_error(buffer, static_cast<double>(depth)) < 1e-6);
    CHECK(sees_only(buffer, 2, 3));
  }
}

TEST_CASE("far from the origin the GPU is as exact as rays") {
  if (no_gl()) return;
  const glm::vec3 away(1 << 17, -(1 << 18), 1 << 16);
  const auto surface = room_surface();
  const Mesh mesh = moved(surface->mesh, away);  // rounded to 1/32 on its way
  const Cells cells = measure_cells(mesh, surface->cells.cell_of_face, surface->cells.size);
  const auto rays = make_ray_visibility(mesh);
  const auto gl = gl_visibility(mesh, cells);
  VisibilityAgreement agreement;
  for (std::size_t number = 0; number < 20; ++number) {
    Camera camera = room_camera(number).scaled_to(400, 300);
    camera.cam_from_world_translation -= camera.cam_from_world_rotation * glm::dvec3(away);
    compare(rays->trace(camera), gl->trace(camera), agreement);
  }
  INFO("equal: " << agreement.share_equal() << ", same face: " << agreement.share_same_face()
                 << ", worst depth: " << agreement.worst_depth);
  CHECK(agreement.share_smooth() > 0.9);
  CHECK(agreement.share_equal() >= kSameFaces);
}

TEST_CASE("leaving out cells that are out of view leaves out every other cell and changes no byte") {
  if (no_gl()) return;
  const Mesh mesh = sphere(5);
  const Cells cells = make_cells(mesh, {.size = 0.2});
  const auto culling = gl_visibility(mesh, cells, true);
  const auto drawing_all = gl_visibility(mesh, cells, false);
  const CellRuns runs(cells, mesh.faces.size());
  std::mt19937 random(7);
  std::size_t drawn = 0;
  constexpr int kCameras = 40;
  for (int i = 0; i < kCameras; ++i) {
    const Camera camera = random_camera(random, 1.2, 160, 120);
    const VisibilityBuffer a = culling->trace(camera);
    const VisibilityBuffer b = drawing_all->trace(camera);
    CHECK(a.face == b.face);
    CHECK(a.depth == b.depth);
    for (const FaceRun& run : runs.in_view(camera)) drawn += run.count;
  }
  CHECK(drawn < mesh.faces.size() * kCameras / 2);
}

TEST_CASE("faces grouped by cell are all faces once, and runs in view are apart and ascending") {
  const Mesh mesh = sphere(4);
  const Cells cells = make_cells(mesh, {.size = 0.2});
  const CellRuns runs(cells, mesh.faces.size());
  for (std::size_t i = 1; i < runs.order().size(); ++i) {
    const auto key = [&](std::size_t place) {
      return std::pair(cells.cell_of_face[runs.order()[place]], runs.order()[place]);
    };
    CHECK(key(i - 1) < key(i));
  }
  CHECK(runs.order().size() == mesh.faces.size());
  std::mt19937 random(23);
  for (int i = 0; i < 20; ++i) {
    std::uint32_t end = 0;
    bool is_first = true;
    for (const FaceRun& run : runs.in_view(random_camera(random, 1.5, 64, 48))) {
      CHECK(run.count >= 1);
      CHECK((is_first ? run.first >= end : run.first > end));
      end = run.first + run.count;
      is_first = false;
    }
    CHECK(end <= mesh.faces.size());
  }
}

TEST_CASE("the GPU names faces exactly where floats would not") {
  if (no_gl()) return;
  // 2^24 + 2 faces behind the camera, all the same one and in a cell that is out of view; then a wall that is seen.
  Mesh mesh = joined(wall_at(-3), wall_at(3));
  const std::array<glm::uvec3, 2> wall{mesh.faces[2], mesh.faces[3]};
  constexpr std::uint32_t kBehind = (1u << 24) + 2;
  mesh.faces.assign(kBehind, mesh.faces[0]);
  mesh.faces.insert(mesh.faces.end(), wall.begin(), wall.end());
  Cells cells;
  cells.size = 1;
  cells.cells = {{.centroid = {0, 0, -40}, .radius = 39, .faces = kBehind},
                 {.centroid = {0, 0, 3}, .radius = 39, .faces = 2}};
  cells.cell_of_face.assign(kBehind, 0);
  cells.cell_of_face.resize(kBehind + 2, 1);
  const Camera camera = straight_camera();
  for (const bool frustum_culling : {true, false}) {
    const VisibilityBuffer buffer = gl_visibility(mesh, cells, frustum_culling)->trace(camera);
    CHECK(sees_only(buffer, kBehind, kBehind + 1));
  }
}

TEST_CASE("several threads may ask the GPU at once, and get what one thread gets") {
  if (no_gl()) return;
  const auto surface = room_surface();
  const auto gl = gl_visibility(surface->mesh, surface->cells);
  const auto camera_of = [](std::uint32_t i) { return room_camera(i).scaled_to(90 + 30 * (i % 6), 80); };
  std::vector<VisibilityBuffer> expected;
  for (std::uint32_t i = 0; i < 24; ++i) expected.push_back(gl->trace(camera_of(i)));
  std::atomic<std::uint32_t> next = 0;
  std::atomic<std::size_t> equal = 0;
  const auto work = [&] {
    VisibilityBuffer buffer;
    for (std::uint32_t i = next++; i < expected.size(); i = next++) {
      gl->trace(camera_of(i), buffer);
      equal += buffer.face == expected[i].face && buffer.depth == expected[i].depth;
    }
  };
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  for (std::thread& thread : threads) thread.join();
  CHECK(equal == expected.size());
}

TEST_CASE("a renderer's context stays current beside GPU visibility, which may be destroyed on another thread") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = room_snapshot(6, {});
  const Mesh& mesh = snapshot.surface->mesh;
  const Cells& cells = snapshot.surface->cells;
  const Camera camera = room_camera(3);
  Renderer renderer;
  renderer.load(snapshot);
  const Rendering before = renderer.render(camera, {});
  const auto unchanged = [&] { return renderer.render(camera, {}).picture.rgb == before.picture.rgb; };
  std::unique_ptr<Visibility> first = gl_visibility(mesh, cells);
  CHECK(unchanged());
  const auto second = gl_visibility(mesh, cells);
  const VisibilityBuffer buffer = first->trace(camera);
  CHECK(unchanged());
  CHECK(second->trace(camera).face == buffer.face);
  std::thread([&] { first.reset(); }).join();
  CHECK(unchanged());
  first = gl_visibility(mesh, cells);
  first.reset();
  CHECK(unchanged());
  CHECK(second->trace(camera).face == buffer.face);
}

TEST_CASE("what the GPU cannot do is refused") {
  if (no_gl()) return;
  const Mesh wall = wall_at(3);
  CHECK_THROWS_AS(make_gl_visibility(Mesh{}, Cells{}), std::invalid_argument);
  CHECK_THROWS_WITH(make_gl_visibility(wall, Cells{}), "cells: they have 0 faces, must have the mesh's 2");
  const auto gl = gl_visibility(wall);
  Camera camera = straight_camera();
  camera.fx = 0;
  CHECK_THROWS_AS(gl->trace(camera), std::invalid_argument);
  // 2^32 pixels are above what OpenGL reads back, whatever the driver says of a side.
  CHECK_THROWS_AS(gl->trace(straight_camera().scaled_to(65536, 65536)), GlError);
  CHECK(depth_error(gl->trace(straight_camera()), 3) < 1e-6);  // and it goes on working
}

TEST_CASE("a camera beyond what floats hold sees nothing") {
  if (no_gl()) return;
  const auto gl = gl_visibility(wall_at(3));
  Camera camera = straight_camera();
  camera.cam_from_world_translation.x = 1e60;
  CHECK(sees_nothing(gl->trace(camera)));
  camera = straight_camera();
  camera.fx = 1e60;
  CHECK(sees_nothing(gl->trace(camera)));
}

}  // namespace
}  // namespace lumatlas
