// SPDX-License-Identifier: GPL-3.0-or-later
// Cameras at the edges: those that see nothing, of extreme focal lengths and sizes, wrongly posed, and new viewpoints
// where no photographer could stand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <optional>
#include <set>

#include "blend/renderer.h"
#include "blend/sampling/supersampling.h"
#include "mesh/visibility/visibility.h"
#include "tests/extremes/extreme_scenes.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"

namespace lumatlas {
namespace {

using Catch::Contains;

Camera looking_away(double place) {
  const Camera camera = court_camera(place);
  return camera_towards(camera.center(), camera.center() - camera.viewing_direction(), 96, 72, 80);
}

double focal_of(double fov_deg, std::uint32_t width) {
  return width / 2.0 / std::tan(glm::radians(fov_deg / 2));
}

// Built, and the picture of the first six cameras' court must be right although other views are in the stream.
BuildResult built_beside_others(const EdgeScene& scene) {
  const BuildResult result = built(scene, default_build());
  const Rendering picture = pictured(result, novel_camera());
  CHECK(textured_share(picture) > 0.6);
  CHECK(textured_error(picture, photographed(court(), novel_camera())) < 16);
  return result;
}

TEST_CASE("cameras that look away are rejected, and do no harm") {
  EdgeScene scene = six_views();
  for (int view = 0; view < 3; ++view) add_view(scene, looking_away(0.3 * view));
  for (const ViewChoice choice : {ViewChoice::online, ViewChoice::offline, ViewChoice::uniform, ViewChoice::random}) {
    BuildOptions options = plain_build();
    options.choice = choice;
    options.max_views = 9;
    options.completion.far_sphere = false;  // which they would see
    const BuildResult result = built(scene, options);
    CHECK(textured_share(pictured(result, novel_camera())) > 0.6);
    if (choice != ViewChoice::online) continue;
    CHECK(count_of(result, Decision::rejected) == 3);
    for (std::size_t view = 6; view < 9; ++view) CHECK(result.planned[view].verdict.cells_seen == 0);
  }
}

TEST_CASE("where all cameras look away, or all but one, a sentence names the mesh and what may be wrong") {
  EdgeScene scene{court(), {}};
  for (int view = 0; view < 20; ++view) add_view(scene, looking_away(0.05 * view));
  CHECK_THAT(refused(scene, default_build()),
             Contains("mesh.ply: 20 of 20 views that were looked through see next to") &&
                 Contains("or the mesh is the wrong one"));
  add_view(scene, court_camera(0.5));
  CHECK_THAT(refused(scene, default_build()), Contains("mesh.ply: 20 of 21 views"));
}

TEST_CASE("three cameras in ten that see the mesh are enough, and are those that are stored") {
  EdgeScene scene{court(), {}};
  for (int view = 0; view < 10; ++view) {
    add_view(scene, view % 4 == 1 ? court_camera(0.1 * view) : looking_away(0.025 * view));
  }
  BuildOptions options = default_build();
  options.completion.far_sphere = false;  // which the others would see
  const BuildResult result = built(scene, options);
  CHECK(stored_names(result) == std::vector<std::string>{"0001.png", "0005.png", "0009.png"});
}

TEST_CASE("focal lengths from 1 to 170 degrees are stored where they help, and spoil nothing") {
  EdgeScene scene = six_views();
  for (const double fov_deg : {1.0, 5.0, 120.0, 170.0}) {
    add_view(scene, camera_towards({3, 3, 2}, {0.7, 0.9, 0.4}, 96, 72, focal_of(fov_deg, 96)));
  }
  const BuildResult result = built_beside_others(scene);
  CHECK(count_of(result, Decision::outlier) == 0);
  for (const double fov_deg : {1.0, 170.0}) {
    EdgeScene alone{court(), {}};
    add_view(alone, camera_towards({3, 3, 2}, {0.7, 0.9, 0.4}, 96, 72, focal_of(fov_deg, 96)));
    const BuildResult one = built(alone, default_build());
    CHECK(stored_names(one).size() == 1);
    CHECK(textured_error(pictured(one, alone.views[0].camera), alone.views[0].photograph) < 4);
  }
}

TEST_CASE("photographs from one pixel to 4000 wide, portrait and landscape, go into one model") {
  EdgeScene scene = six_views();
  const glm::dvec3 from(4, 3, 2), at(0.8, 0.9, 0.7);
  const std::vector<glm::uvec2> sizes{{1, 1}, {2, 3}, {16, 16}, {300, 1}, {1, 300}, {60, 90}, {4000, 8}, {1000, 700}};
  for (const glm::uvec2& size : sizes) {
    add_view(scene, camera_towards(from, at, size.x, size.y, 0.8 * std::max(size.x, size.y)));
  }
  (void)built_beside_others(scene);
  for (const glm::uvec2& size : sizes) {
    CAPTURE(size.x, size.y);
    EdgeScene alone{court(), {}};
    add_view(alone, camera_towards(from, at, size.x, size.y, 0.8 * std::max(size.x, size.y)));
    add_view(alone, camera_towards(from + 0.1, at, size.x, size.y, 0.8 * std::max(size.x, size.y)));
    BuildOptions options = default_build();
    options.tiles = {64, 4, 0};
    const BuildResult result = built(alone, options);
    CHECK_FALSE(stored_names(result).empty());
    CHECK(count_of(result, Decision::outlier) == 0);
  }
}

TEST_CASE("small photographs are not outliers for want of points") {
  EdgeScene scene{court(), {}};
  for (int view = 0; view < 8; ++view) {
    const Camera camera = court_camera((view + 0.5) / 8);
    add_view(scene, camera.scaled_to(16, 16));
  }
  const BuildResult result = built(scene, default_build());
  CHECK(count_of(result, Decision::outlier) == 0);
  CHECK(stored_names(result).size() >= 3);
}

TEST_CASE("a principal point outside the picture, and pixels that are not square, are what they are") {
  EdgeScene scene{court(), {}};
  for (int view = 0; view < 4; ++view) {
    Camera camera = court_camera(0.2 * view + 0.2);
    camera.cx += 40;
    camera.cy -= 50;
    camera.fy *= 2;
    add_view(scene, camera);
  }
  const BuildResult result = built(scene, default_build());
  const Camera& camera = scene.views[1].camera;
  CHECK(textured_error(pictured(result, camera), scene.views[1].photograph) < 8);
}

TEST_CASE("views with poses that are plainly wrong are answered for, and the others are shown") {
  EdgeScene scene = court_scene(10);
  for (const std::size_t wrong : {4u, 7u}) {  // once the right ones are there to be compared with
    scene.views[wrong].camera = camera_towards({5, 1, 3.5}, {0.2, 2.5, 0.1}, 96, 72, 80);
  }
  const BuildResult result = built(scene, default_build());
  CHECK(count_of(result, Decision::outlier) + count_of(result, Decision::rejected) >= 1);
  const Rendering picture = pictured(result, novel_camera());
  CHECK(textured_error(picture, photographed(court(), novel_camera())) < 24);
}

TEST_CASE("poses that are all wrong by a lot neither crash nor lose a view") {
  EdgeScene scene = six_views();
  for (std::size_t view = 0; view < scene.views.size(); ++view) {
    scene.views[view].camera = court_camera(1 - static_cast<double>(view) / 6);  // the photographs of another view
  }
  CHECK_FALSE(stored_names(built(scene, default_build())).empty());
}

// Returns cameras that no photographer can have: inside the mesh, behind a face, on a vertex, in a face, grazing, far
// away.
std::vector<Camera> odd_places() {
  const glm::dvec3 vertex = court().positions[40];
  const TriangleSoup soup = court();
  const glm::uvec3 face = soup.faces[20];
  const glm::dvec3 on_face = (soup.positions[face.x] + soup.positions[face.y] + soup.positions[face.z]) / 3.0;
  return {camera_towards({-1, -2, -1.5}, {1, 1, 1}, 60, 40, 40),  // behind the walls
          camera_towards(vertex, {2, 2, 2}, 60, 40, 40),          // exactly on a vertex
          camera_towards(vertex, vertex - glm::dvec3(1, 1, 1), 60, 40, 40),
          camera_towards(on_face, {2, 2, 2}, 60, 40, 40),          // in a face
          camera_towards({4.5, 2, 1e-3}, {0, 2, 0}, 60, 40, 40),   // grazing the floor
          camera_towards({2, 2, 0.01}, {2, 2, -1}, 60, 40, 40),    // nose to the ground
          camera_towards({1e6, 1e6, 1e6}, {1, 1, 1}, 60, 40, 40),  // far away
          camera_towards({1e12, 0, 0}, {0, 0, 0}, 60, 40, 40),
          camera_towards({3, 3, 2}, {9, 9, 9}, 60, 40, 40),     // looking away
          camera_towards({3, 3, 2}, {1, 1, 1}, 1, 1, 1),        // a single pixel
          camera_towards({3, 3, 2}, {1, 1, 1}, 2000, 1, 1000),  // a line
          camera_towards({3, 3, 2}, {1, 1, 1}, 60, 40, 1e-3),   // nearly 180 degrees
          camera_towards({3, 3, 2}, {1, 1, 1}, 60, 40, 1e9)};   // and nearly none
}

TEST_CASE("new viewpoints in odd places give a picture, each pixel of it black, a vertex's or a photograph's colour") {
  const BuildResult result = built(six_views(), default_build());
  for (const Camera& camera : odd_places()) {
    const Rendering picture = pictured(result, camera);
    CHECK(picture.picture.width == camera.width);
    CHECK(picture.picture.height == camera.height);
    for (std::size_t pixel = 0; pixel < picture.state.size(); ++pixel) {
      if (picture.state[pixel] != PixelState::empty) continue;
      CHECK(picture.picture.rgb[3 * pixel] == 0);
    }
  }
  const Rendering away = pictured(result, odd_places()[8]);
  CHECK(std::all_of(away.state.begin(), away.state.end(), [](PixelState s) { return s == PixelState::empty; }));
}

TEST_CASE("the shader's pictures from odd places are finite, and those from less odd ones are the CPU's") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const BuildResult result = built(six_views(), default_build());
  Renderer renderer;
  renderer.load(result.snapshot);
  const std::set<std::size_t> defined{0, 6, 8, 9, 10};  // elsewhere rounding, or the near plane, says what is visible
  const std::vector<Camera> places = odd_places();
  for (std::size_t place = 0; place < places.size(); ++place) {
    CAPTURE(place);
    Camera camera = places[place];
    camera.cam_from_world_translation += camera.cam_from_world_rotation * result.snapshot.surface->offset;
    const LinearRendering linear = renderer.render_linear(camera, BlendOptions{});
    CHECK(linear.rgb.size() == 3 * std::size_t{camera.width} * camera.height);
    CHECK(std::all_of(linear.rgb.begin(), linear.rgb.end(), [](float v) { return std::isfinite(v) && v >= 0; }));
    if (!defined.contains(place)) continue;
    CHECK(share_different(renderer.render(camera, at_middle({})), pictured(result, places[place]), 3) < 0.05);
  }
}

TEST_CASE("cameras inside the mesh, on a vertex or at its skin may be offered as views, too") {
  EdgeScene scene = six_views();
  for (const Camera& camera : odd_places()) {
    if (camera.fx < 1e-2) continue;  // a picture of one direction and its opposite: nothing to photograph
    add_view(scene, camera);
  }
  const BuildResult result = built_beside_others(scene);
  CHECK(stored_names(result).size() >= 4);
}

}  // namespace
}  // namespace lumatlas
