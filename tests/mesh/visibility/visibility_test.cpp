// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/visibility.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numeric>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/cells/split_faces.h"
#include "mesh/visibility/ray_visibility.h"

namespace lumatlas {
namespace {

// At the origin, looking along z; an odd size, so that packets of rays hang over the border.
Camera straight_camera() {
  Camera camera;
  camera.width = 33;
  camera.height = 21;
  camera.fx = 20;
  camera.fy = 22;
  camera.cx = 16;
  camera.cy = 11;
  return camera;
}

// A square of two triangles across the axis, wider than the image.
Mesh wall_at(float z) {
  Mesh mesh;
  mesh.positions = {{-9, -9, z}, {9, -9, z}, {9, 9, z}, {-9, 9, z}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

Mesh random_triangles(std::uint32_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-2, 2);
  Mesh mesh;
  for (std::uint32_t face = 0; face < count; ++face) {
    const glm::vec3 middle(2 * uniform(random), 2 * uniform(random), 4 + uniform(random));
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back(middle + 0.5f * glm::vec3(uniform(random), uniform(random), uniform(random)));
    }
    mesh.faces.emplace_back(3 * face, 3 * face + 1, 3 * face + 2);
  }
  return mesh;
}

// Depth at which the ray of unit depth meets the triangle, in double precision; infinity where it does not. `margin` is
// how far inside the triangle it does, in barycentric coordinates.
double hit_depth(const Mesh& mesh, const glm::uvec3& face, const glm::dvec3& ray, double& margin) {
  const glm::dvec3 a(mesh.positions[face.x]);
  const glm::dmat3 system(ray, a - glm::dvec3(mesh.positions[face.y]), a - glm::dvec3(mesh.positions[face.z]));
  const glm::dvec3 solution = glm::inverse(system) * a;  // depth, and the weights of the two other corners
  margin = std::min({solution.y, solution.z, 1 - solution.y - solution.z});
  return margin >= 0 && solution.x > 0 ? solution.x : std::numeric_limits<double>::infinity();
}

TEST_CASE("depth is z in the camera frame, not the distance along the ray") {
  const VisibilityBuffer buffer = make_ray_visibility(wall_at(3))->trace(straight_camera());
  REQUIRE(buffer.depth.size() == 33 * 21);
  for (const float depth : buffer.depth) CHECK(depth == Approx(3).epsilon(1e-5));
}

TEST_CASE("a surface is seen from behind as from the front, and one behind the camera is not seen") {
  Mesh turned = wall_at(3);
  for (glm::uvec3& face : turned.faces) std::swap(face.y, face.z);
  for (const std::uint32_t face : make_ray_visibility(turned)->trace(straight_camera()).face)
    CHECK(face != FaceId::none);
  const VisibilityBuffer behind = make_ray_visibility(wall_at(-3))->trace(straight_camera());
  for (std::size_t pixel = 0; pixel < behind.face.size(); ++pixel) {
    CHECK(behind.face[pixel] == FaceId::none);
    CHECK(std::isinf(behind.depth[pixel]));
  }
}

TEST_CASE("pixels are sampled at their centres") {
  // The wall's edge at x = 0 projects to the principal point's column, 16: the centre 15.5 is left of it, 16.5 right.
  Mesh half = wall_at(2);
  half.positions[0].x = half.positions[3].x = 0;
  const VisibilityBuffer buffer = make_ray_visibility(half)->trace(straight_camera());
  for (std::size_t y = 0; y < 21; ++y) {
    CHECK(buffer.face[33 * y + 15] == FaceId::none);
    CHECK(buffer.face[33 * y + 16] != FaceId::none);
  }
}

TEST_CASE("the nearest triangle of many is found, as by trying them all") {
  const Mesh mesh = random_triangles(200, 5);
  Camera camera = straight_camera();
  const VisibilityBuffer buffer = make_ray_visibility(mesh)->trace(camera);
  std::size_t compared = 0;
  for (std::size_t pixel = 0; pixel < buffer.face.size(); ++pixel) {
    const glm::dvec3 ray = camera.ray({static_cast<double>(pixel % 33) + 0.5, static_cast<double>(pixel / 33) + 0.5});
    double nearest = std::numeric_limits<double>::infinity();
    double least_margin = 1;  // of any triangle's border, where rounding decides
    for (const glm::uvec3& face : mesh.faces) {
      double margin = 0;
      nearest = std::min(nearest, hit_depth(mesh, face, ray, margin));
      least_margin = std::min(least_margin, std::abs(margin));
    }
    if (least_margin < 1e-4) continue;
    ++compared;
    if (std::isinf(nearest)) {
      CHECK(buffer.face[pixel] == FaceId::none);
    } else {
      CHECK(static_cast<double>(buffer.depth[pixel]) == Approx(nearest).epsilon(1e-4));
    }
  }
  CHECK(compared > buffer.face.size() / 2);
}

TEST_CASE("no ray leaks through the edges that faces share") {
  // A fine closed box seen from a point inside, turned so that edges cross pixels at every angle.
  Mesh box;
  for (int corner = 0; corner < 8; ++corner) {
    box.positions.emplace_back(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
  }
  box.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  const Mesh fine = split_large_faces(box, 0.05);
  const auto visibility = make_ray_visibility(fine);
  for (int turn = 0; turn < 12; ++turn) {
    Camera camera = straight_camera().scaled_to(200, 150);
    camera.cam_from_world_rotation = glm::mat3_cast(glm::angleAxis(0.5 * turn, glm::normalize(glm::dvec3(1, 2, turn))));
    camera.cam_from_world_translation = camera.cam_from_world_rotation * glm::dvec3(0.1, -0.2, 0.3);
    const VisibilityBuffer buffer = visibility->trace(camera);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), FaceId::none) == 0);
  }
}

TEST_CASE("the buffer is the same for one thread and for many, and its memory is reused for another size") {
  const auto visibility = make_ray_visibility(random_triangles(300, 9));
  const Camera camera = straight_camera().scaled_to(301, 199);
  VisibilityBuffer one;
  {
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    visibility->trace(camera, one);
  }
  const VisibilityBuffer many = visibility->trace(camera);
  CHECK(one.face == many.face);
  CHECK(one.depth == many.depth);
  visibility->trace(straight_camera(), one);
  CHECK(one.width == 33);
  CHECK(one.face.size() == 33 * 21);
}

TEST_CASE("a part of the buffer is that part of the whole to the bit, and nothing is seen elsewhere") {
  const RayVisibility visibility(random_triangles(300, 9));
  const bool sparse = GENERATE(false, true);  // small images get all rays
  const Camera camera = sparse ? straight_camera().scaled_to(801, 599) : straight_camera().scaled_to(301, 199);
  const VisibilityBuffer whole = visibility.trace_sparsely(camera);
  CHECK((visibility.trace(camera).depth == whole.depth) == !sparse);
  std::mt19937 random(4);
  for (const std::uint32_t one_of : {1u, 2u, 30u, 2000u, 20000u}) {
    std::vector<std::uint8_t> wanted(whole.face.size());
    for (std::uint8_t& pixel : wanted) pixel = random() % one_of == 0 ? 1 : 0;
    VisibilityBuffer part;
    visibility.trace_part(camera, {0, 0, camera.width, camera.height}, wanted, part);
    REQUIRE(part.face.size() == whole.face.size());
    std::size_t seen = 0;
    for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) {
      const bool same = part.face[pixel] == whole.face[pixel] && part.depth[pixel] == whole.depth[pixel];
      const bool nothing = part.face[pixel] == FaceId::none && std::isinf(part.depth[pixel]);
      if (!(wanted[pixel] ? same : nothing)) FAIL_CHECK("one of " << one_of << ", pixel " << pixel);
      seen += part.face[pixel] != FaceId::none ? 1 : 0;
    }
    CHECK(seen > 0);
  }
  VisibilityBuffer part;
  CHECK_THROWS_AS(
      visibility.trace_part(camera, {0, 0, camera.width, camera.height}, std::vector<std::uint8_t>(3, 1), part),
      std::invalid_argument);
}

TEST_CASE("wanted pixels are those of the whole to the bit") {
  const RayVisibility visibility(random_triangles(300, 9));
  const Camera camera = straight_camera().scaled_to(161, 119);
  const VisibilityBuffer whole = visibility.trace(camera);
  std::mt19937 random(4);
  for (const std::uint32_t one_of : {1u, 2u, 30u, 2000u}) {
    std::vector<std::uint8_t> wanted(whole.face.size());
    for (std::uint8_t& pixel : wanted) pixel = random() % one_of == 0 ? 1 : 0;
    VisibilityBuffer part;
    visibility.trace_wanted(camera, wanted, part);
    REQUIRE(part.face.size() == whole.face.size());
    for (std::size_t pixel = 0; pixel < wanted.size(); ++pixel) {
      if (wanted[pixel] == 0) continue;
      if (part.face[pixel] != whole.face[pixel] || part.depth[pixel] != whole.depth[pixel]) FAIL_CHECK(pixel);
    }
  }
  VisibilityBuffer part;
  CHECK_THROWS_WITH(visibility.trace_wanted(camera, std::vector<std::uint8_t>(3, 1), part),
                    Catch::Contains("wanted has 3 values, must have one per pixel of 161x119"));
}

TEST_CASE("a window of the buffer is that window of the whole to the bit") {
  const RayVisibility visibility(random_triangles(300, 9));
  const Camera camera = straight_camera().scaled_to(801, 599);
  const VisibilityBuffer whole = visibility.trace_sparsely(camera);
  for (const PixelRect& part : {PixelRect{0, 0, 10, 10}, PixelRect{390, 250, 70, 3}, PixelRect{700, 598, 101, 1}}) {
    const PixelRect window = window_for_part(camera, part);
    CHECK(window.pixels() < whole.face.size());
    std::vector<std::uint8_t> wanted(window.pixels(), 0);
    for (std::uint32_t y = part.y - window.y; y < part.bottom() - window.y; ++y) {
      std::fill_n(wanted.begin() + y * window.width + part.x - window.x, part.width, std::uint8_t{1});
    }
    VisibilityBuffer buffer;
    visibility.trace_part(camera, window, wanted, buffer);
    REQUIRE(buffer.face.size() == window.pixels());
    for (std::uint32_t y = part.y; y < part.bottom(); ++y) {
      for (std::uint32_t x = part.x; x < part.right(); ++x) {
        const std::size_t here = std::size_t{y - window.y} * window.width + x - window.x;
        const std::size_t there = std::size_t{y} * camera.width + x;
        if (buffer.face[here] == whole.face[there] && buffer.depth[here] == whole.depth[there]) continue;
        FAIL_CHECK("pixel " << x << ", " << y);
      }
    }
  }
  VisibilityBuffer buffer;
  const std::vector<std::uint8_t> wanted(64 * 64, 1);
  CHECK_THROWS_AS(visibility.trace_part(camera, {8, 0, 64, 64}, wanted, buffer), std::invalid_argument);
  CHECK_THROWS_AS(visibility.trace_part(camera, {768, 0, 64, 64}, wanted, buffer), std::invalid_argument);
}

// Seen from the origin along z, as a wave of hills that bends slowly, with a hole and a box in front of it.
Mesh hills_behind_a_box() {
  constexpr std::uint32_t kQuads = 120;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= kQuads; ++j) {
    for (std::uint32_t i = 0; i <= kQuads; ++i) {
      const glm::vec2 at = 8.f * (glm::vec2(i, j) / static_cast<float>(kQuads) - 0.5f);
      mesh.positions.emplace_back(at, 5 + 0.3f * std::sin(2 * at.x) * std::cos(at.y) + 0.4f * at.x);
    }
  }
  for (std::uint32_t j = 0; j < kQuads; ++j) {
    for (std::uint32_t i = 0; i < kQuads; ++i) {
      if (i > 80 && i < 90 && j > 50 && j < 70) continue;
      const std::uint32_t a = j * (kQuads + 1) + i;
      mesh.faces.insert(mesh.faces.end(), {{a, a + 1, a + kQuads + 2}, {a, a + kQuads + 2, a + kQuads + 1}});
    }
  }
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const float x : {-0.7f, 0.2f}) {
    for (const float y : {-0.5f, 0.4f}) mesh.positions.emplace_back(x, y, 3 + 0.2f * x);
  }
  mesh.faces.insert(mesh.faces.end(), {{first, first + 1, first + 2}, {first + 1, first + 3, first + 2}});
  return mesh;
}

// Returns whether a pixel shows another surface than a neighbour, by depth.
bool at_depth_edge(const VisibilityBuffer& buffer, std::size_t x, std::size_t y) {
  const float z = buffer.depth[y * buffer.width + x];
  for (std::size_t row = y - std::min<std::size_t>(y, 1); row <= y + 1 && row < buffer.height; ++row) {
    for (std::size_t column = x - std::min<std::size_t>(x, 1); column <= x + 1 && column < buffer.width; ++column) {
      const float other = buffer.depth[row * buffer.width + column];
      if (std::isinf(z) != std::isinf(other) || std::abs(z - other) > 0.1f * z) return true;
    }
  }
  return false;
}

TEST_CASE("sparse rays find depth to a thousandth, edges of depth to the pixel, and faces of the neighbourhood") {
  const Mesh mesh = hills_behind_a_box();
  const RayVisibility visibility(mesh);
  for (const auto& [width, height] : {std::pair{640u, 480u}, {641u, 479u}, {3u, 60000u}}) {
    CAPTURE(width, height);
    const Camera camera = straight_camera().scaled_to(width, height);
    const VisibilityBuffer whole = visibility.trace(camera);
    const VisibilityBuffer sparse = visibility.trace_sparsely(camera);
    REQUIRE(sparse.face.size() == whole.face.size());
    double worst = 0;
    std::size_t wrong = 0, interpolated = 0, edges = 0, far_face = 0;
    for (std::size_t pixel = 0; pixel < whole.face.size(); ++pixel) {
      const bool seen = whole.face[pixel] != FaceId::none;
      wrong += (sparse.face[pixel] != FaceId::none) != seen || std::isinf(sparse.depth[pixel]) == seen;
      if (!seen || sparse.face[pixel] == FaceId::none) continue;
      worst = std::max(worst, std::abs(static_cast<double>(sparse.depth[pixel]) / whole.depth[pixel] - 1));
      interpolated += std::abs(sparse.depth[pixel] - whole.depth[pixel]) > 1e-6f * whole.depth[pixel];
      edges += at_depth_edge(whole, pixel % width, pixel / width);
      const glm::vec3 one = mesh.positions[mesh.faces[whole.face[pixel]].x];
      far_face += glm::length(one - mesh.positions[mesh.faces[sparse.face[pixel]].x]) > 1.0f;
    }
    CHECK(wrong == 0);
    CHECK(far_face == 0);
    CHECK(worst < 1e-3);
    if (width < 600) continue;
    CHECK(edges > 1000);                          // they are there to be found
    CHECK(interpolated > whole.face.size() / 4);  // and most rays are spared
  }
}

TEST_CASE("sparse rays are the same on any number of threads, and small images get all rays") {
  const RayVisibility visibility(hills_behind_a_box());
  const Camera camera = straight_camera().scaled_to(501, 399);
  VisibilityBuffer one;
  {
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    visibility.trace_sparsely(camera, one);
  }
  const VisibilityBuffer many = visibility.trace_sparsely(camera);
  CHECK(one.face == many.face);
  CHECK(one.depth == many.depth);
  const Camera small = straight_camera().scaled_to(301, 199);
  CHECK(visibility.trace_sparsely(small).depth == visibility.trace(small).depth);
  Camera bad = camera;
  bad.fx = 0;
  CHECK_THROWS_AS(visibility.trace_sparsely(bad), std::invalid_argument);
}

TEST_CASE("cells' pixels add up to the pixels that see the mesh, in ascending order of cells") {
  const Mesh mesh = split_large_faces(wall_at(4), 2);
  CellOptions options;
  options.size = 2;
  const Cells cells = make_cells(mesh, options);
  const VisibilityBuffer buffer = make_ray_visibility(mesh)->trace(straight_camera());
  const std::vector<CellPixels> counts = count_cell_pixels(buffer, cells);
  REQUIRE(counts.size() > 2);
  std::size_t sum = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    sum += counts[i].pixels;
    CHECK(counts[i].pixels >= 1);
    if (i > 0) CHECK(counts[i].cell > counts[i - 1].cell);
  }
  CHECK(sum == buffer.face.size());  // the wall fills the image
}

TEST_CASE("a mesh without faces, and a bad camera, are refused") {
  CHECK_THROWS_AS(make_ray_visibility(Mesh{}), std::invalid_argument);
  Camera camera = straight_camera();
  camera.fx = 0;
  CHECK_THROWS_AS(make_ray_visibility(wall_at(3))->trace(camera), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
