// SPDX-License-Identifier: GPL-3.0-or-later
// A picture that is drawn in parts is the picture in one piece.
#include "blend/gl/picture_parts.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <vector>

#include "blend/renderer.h"
#include "blend/tables/drawn_runs.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("parts cover each pixel once, with what is around it, at one size") {
  for (const std::uint32_t width : {1u, 63u, 64u, 65u, 300u, 1920u}) {
    for (const std::uint32_t height : {1u, 70u, 641u}) {
      CAPTURE(width, height);
      std::vector<int> covered(std::size_t{width} * height, 0);
      const std::vector<PicturePart> parts = parts_of(width, height, 64);
      for (const auto& [drawn, copied] : parts) {
        CHECK(drawn.width == parts.front().drawn.width);
        CHECK(drawn.height == parts.front().drawn.height);
        CHECK(std::max(copied.width, copied.height) <= 64);
        REQUIRE(drawn.left + drawn.width <= width);
        REQUIRE(drawn.top + drawn.height <= height);
        CHECK((drawn.left == 0 || drawn.left + kAroundPart <= copied.left));
        CHECK((drawn.top == 0 || drawn.top + kAroundPart <= copied.top));
        const std::uint32_t right = copied.left + copied.width, bottom = copied.top + copied.height;
        CHECK(drawn.left + drawn.width >= std::min(width, right + kAroundPart));
        CHECK(drawn.top + drawn.height >= std::min(height, bottom + kAroundPart));
        for (std::uint32_t y = copied.top; y < bottom; ++y) {
          for (std::uint32_t x = copied.left; x < right; ++x) ++covered[std::size_t{y} * width + x];
        }
      }
      CHECK(covered == std::vector<int>(covered.size(), 1));
    }
  }
  CHECK(parts_of(640, 640, 640).size() == 1);
  CHECK(parts_of(641, 640, 640).size() == 2);
}

TEST_CASE("the camera of a part sees each pixel where the picture's does") {
  const Camera camera = room_camera(3).scaled_to(300, 200);
  const Camera part = camera_of_part(camera, {70, 30, 100, 90});
  CHECK_NOTHROW(check(part));
  CHECK(glm::length(part.ray({10.5, 20.5}) - camera.ray({80.5, 50.5})) < 1e-12);
}

TEST_CASE("pictures, linear pictures and diagnoses in parts are those in one piece") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot snapshot = exposed_room_snapshot(10);
  Renderer whole, parts({.part_px = 64});
  whole.load(snapshot);
  parts.load(snapshot);
  for (std::size_t number = 0; number < 4; ++number) {
    Camera camera = room_camera(2 * number + 1).scaled_to(307, 227);
    camera.cam_from_world_translation += glm::dvec3(0.1, 0.05, -0.1);
    CAPTURE(number);
    const Rendering expected = whole.render(camera, {});
    CHECK(share_different(parts.render(camera, {}), expected, 1) <= 0.0005);
    const LinearRendering linear = whole.render_linear(camera, {}), in_parts = parts.render_linear(camera, {});
    const Diagnosis diagnosis = whole.diagnose(camera, {}), diagnosed = parts.diagnose(camera, {});
    std::size_t different = 0;
    for (std::size_t pixel = 0; pixel < expected.state.size(); ++pixel) {
      different += in_parts.state[pixel] != linear.state[pixel] ||
                   std::abs(in_parts.rgb[3 * pixel] - linear.rgb[3 * pixel]) > 0.01f ||
                   diagnosed.pixels[pixel].winner != diagnosis.pixels[pixel].winner;
    }
    CHECK(different <= 30);  // of 69689
  }
}

TEST_CASE("what a large picture is drawn into takes little more than the picture") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  Snapshot snapshot = room_snapshot(4, {});
  snapshot.cell_deviation.assign(snapshot.surface->cells.cells.size(), 0.05F);
  Renderer renderer;
  renderer.load(snapshot);
  (void)renderer.render(room_camera(1).scaled_to(1920, 1080), {});
  CHECK(renderer.work().targets < 60'000'000);
  renderer.set_options({.part_px = 4000});
  (void)renderer.render(room_camera(1).scaled_to(1920, 1080), {});
  CHECK(renderer.work().targets == 1920 * 1080 * (16 + 8 + 4 + 4 * (16 + 8) + 4 + 4 + 4 + 4));
  CHECK_THROWS_WITH(renderer.set_options({.part_px = 63}), "renderer: part_px is 63, must be in [64, 4000]");
  CHECK_THROWS_WITH(Renderer({.part_px = 4001}), "renderer: part_px is 4001, must be in [64, 4000]");
}

// Returns faces at the points of a grid in the plane z = 1, a square of 32 x 32 points after another.
ZoneMesh grid_of_faces(std::uint32_t across) {
  ZoneMesh mesh;
  for (std::uint32_t face = 0; face < across * across; ++face) {
    const std::uint32_t square = face / 1024, squares = across / 32;
    const glm::vec3 at(square % squares * 32 + face % 32, square / squares * 32 + face % 1024 / 32, 1);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& corner : {glm::vec3(0), glm::vec3(0.25, 0, 0), glm::vec3(0, 0.25, 0)}) {
      mesh.positions.push_back(at + corner);
    }
    mesh.faces.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

TEST_CASE("all faces in view are in the runs that are drawn, and few others") {
  constexpr std::uint32_t kAcross = 128;
  ZoneMesh mesh = grid_of_faces(kAcross);
  mesh.face_counts = {kAcross * kAcross / 2, 0, kAcross * kAcross / 2};
  const DrawnRuns runs(mesh);
  Camera camera = centered_camera(100, 100, 50);
  camera.cam_from_world_translation = {-40, -20, 5};  // sees a square of 12 around (40, 20)
  const DrawnRuns::OfShaders seen = runs.in_view(camera);
  CHECK(seen[1].empty());
  std::vector<int> drawn(mesh.faces.size(), 0);
  std::size_t count = 0;
  for (const std::vector<FaceRun>& of_shader : seen) {
    for (const FaceRun& run : of_shader) {
      CHECK((&of_shader == &seen[0] ? run.first + run.count <= mesh.face_counts[0] : run.first >= mesh.face_counts[0]));
      for (std::uint32_t face = run.first; face < run.first + run.count; ++face) ++drawn.at(face);
      count += run.count;
    }
  }
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(mesh.positions[mesh.faces[face].x]));
    const bool in_image = at.x >= 0 && at.y >= 0 && at.x < 100 && at.y < 100;
    if (in_image) CHECK(drawn[face] == 1);
    CHECK(drawn[face] <= 1);
  }
  CHECK(count < mesh.faces.size() / 2);
  camera.cam_from_world_translation.z = -50;  // all is behind
  for (const std::vector<FaceRun>& of_shader : runs.in_view(camera)) CHECK(of_shader.empty());
}

}  // namespace
}  // namespace lumatlas
