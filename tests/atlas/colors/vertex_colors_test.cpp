// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/colors/vertex_colors.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "atlas/atlas.h"
#include "atlas/images/srgb.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("all 256 sRGB values come back from linear light") {
  const auto& linear = linear_from_srgb8();
  for (int value = 0; value < 256; ++value) {
    CHECK(srgb8_from_linear(linear_from_srgb(value / 255.0)) == value);
    CHECK(srgb8_from_linear(static_cast<double>(linear[static_cast<std::size_t>(value)])) == value);
  }
  CHECK(linear[0] == 0);
  CHECK(linear[255] == 1);
}

TEST_CASE("the two transfer functions are inverse and rise, across the change from line to power too") {
  double previous = -1;
  for (int step = 0; step <= 10000; ++step) {
    const double srgb = step / 10000.0, linear = linear_from_srgb(srgb);
    CHECK(linear > previous);
    CHECK(srgb_from_linear(linear) == Approx(srgb).margin(1e-7));  // the standard's line and power meet within 3e-8
    previous = linear;
  }
}

TEST_CASE("light outside of the range is clamped") {
  CHECK(srgb8_from_linear(-3) == 0);
  CHECK(srgb8_from_linear(1.0001) == 255);
  CHECK(srgb8_from_linear(1e30) == 255);
}

// One wall of 2x2 squares, of which a forward camera at the origin sees all 9 vertices.
Mesh wall() {
  Mesh mesh;
  add_wall(mesh, 2, 2, 1, 4);
  return mesh;
}

// All of one colour and valid, with the wall's depth.
StoredView flat_view(const glm::u8vec3& color, float depth = 4) {
  StoredView view;
  view.camera = forward_camera(16, 16);
  Photograph photograph{16, 16, {}, {}};
  for (int pixel = 0; pixel < 256; ++pixel) {
    photograph.rgb.insert(photograph.rgb.end(), {color.r, color.g, color.b});
  }
  view.photograph = std::make_shared<const StoredPhotograph>(std::move(photograph));
  own_mask(view).depth.values().assign(256, depth);
  own_mask(view).validity.values().assign(256, 255);
  return view;
}

std::vector<glm::u8vec3> mean_of(const Mesh& mesh, const std::vector<StoredView>& views) {
  VertexColorMean mean(mesh);
  for (const StoredView& view : views) mean.add(view, glm::dvec3(1));
  return mean.colors();
}

std::vector<glm::u8vec3> all(const Mesh& mesh, const glm::u8vec3& color) {
  return std::vector<glm::u8vec3>(mesh.positions.size(), color);
}

TEST_CASE("a vertex has the colour of the pixel that shows it") {
  const Mesh mesh = wall();
  StoredView view = flat_view({0, 0, 0});
  view.photograph = std::make_shared<const StoredPhotograph>(position_photograph(16, 16));
  const std::vector<glm::u8vec3> colors = mean_of(mesh, {view});
  for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
    const glm::dvec2 image = view.camera.image_from_cam(glm::dvec3(mesh.positions[vertex]));
    const std::size_t pixel = 16 * static_cast<std::size_t>(image.y) + static_cast<std::size_t>(image.x);
    for (int channel = 0; channel < 3; ++channel) {
      CHECK(colors[vertex][channel] == view.photograph->color(pixel).at(static_cast<std::size_t>(channel)));
    }
  }
}

TEST_CASE("the mean is taken in linear light") {
  const Mesh mesh = wall();
  // Half the light of white is 188 by the standard, not 128.
  CHECK(mean_of(mesh, {flat_view({0, 255, 40}), flat_view({255, 255, 40})}) == all(mesh, {188, 255, 40}));
}

TEST_CASE("a view's gain scales its light, channel by channel") {
  const Mesh mesh = wall();
  VertexColorMean mean(mesh);
  mean.add(flat_view({255, 128, 128}), {0.5, 0.5, 1});
  CHECK(mean.colors() == all(mesh, {188, 92, 128}));  // 128 is 0.2159 in linear light, its half is 92.4
}

TEST_CASE("each view has its own gain") {
  const Mesh mesh = wall();
  VertexColorMean mean(mesh);
  mean.add(flat_view({255, 255, 0}), {0.25, 1, 1});
  mean.add(flat_view({255, 0, 255}), {0.75, 1, 0.5});
  const std::uint8_t quarter = srgb8_from_linear(0.25);
  CHECK(mean.colors() == all(mesh, {188, 188, quarter}));
}

TEST_CASE("a view counts by its validity") {
  const Mesh mesh = wall();
  StoredView weak = flat_view({255, 255, 255});
  own_mask(weak).validity.values().assign(256, 85);
  const std::uint8_t quarter = srgb8_from_linear(0.25);  // a third against one
  CHECK(mean_of(mesh, {flat_view({0, 0, 0}), weak}) == all(mesh, glm::u8vec3(quarter)));
  own_mask(weak).validity.values().assign(256, 0);
  CHECK(mean_of(mesh, {flat_view({9, 9, 9}), weak}) == all(mesh, glm::u8vec3(9)));
}

TEST_CASE("a rim counts next to nothing, and colours what no other view shows") {
  const Mesh mesh = wall();
  StoredView rim = flat_view({255, 255, 255});
  own_mask(rim).rim.values().assign(256, 1);
  CHECK(mean_of(mesh, {rim}) == all(mesh, {255, 255, 255}));
  const auto beside_another = mean_of(mesh, {flat_view({0, 0, 0}), rim});
  CHECK(beside_another == all(mesh, glm::u8vec3(srgb8_from_linear(1e-3 / 1.001))));
}

TEST_CASE("a view before which something stands does not count") {
  const Mesh mesh = wall();
  const StoredView good = flat_view({10, 20, 30});
  CHECK(mean_of(mesh, {good, flat_view({200, 0, 0}, 4 / 1.03f)}) == all(mesh, {10, 20, 30}));
  CHECK(mean_of(mesh, {flat_view({10, 20, 30}, 4 / 1.01f)}) == all(mesh, {10, 20, 30}));  // within the tolerance
}

TEST_CASE("what lies behind a camera or outside of its image does not count") {
  const Mesh mesh = wall();
  StoredView behind = flat_view({200, 0, 0}, 100);
  behind.camera.cam_from_world_translation.z = -9;
  StoredView aside = flat_view({200, 0, 0}, 100);
  aside.camera.cx = 1000;
  StoredView at_vertex = flat_view({200, 0, 0}, 100);
  at_vertex.camera.cam_from_world_translation.z = -4;  // z = 0: no position in the image
  CHECK(mean_of(mesh, {flat_view({1, 2, 3}), behind, aside, at_vertex}) == all(mesh, {1, 2, 3}));
}

TEST_CASE("a vertex that no view showed has the mesh's own colour") {
  Mesh mesh = wall();
  mesh.colors = all(mesh, {7, 8, 9});
  CHECK(mean_of(mesh, {}) == all(mesh, {7, 8, 9}));
  StoredView left_half = flat_view({50, 60, 70});
  for (std::size_t pixel = 0; pixel < 256; ++pixel) {
    if (pixel % 16 >= 8) own_mask(left_half).validity.values()[pixel] = 0;
  }
  const std::vector<glm::u8vec3> colors = mean_of(mesh, {left_half});
  for (std::size_t vertex = 0; vertex < colors.size(); ++vertex) {
    CHECK(colors[vertex] == (mesh.positions[vertex].x < 0 ? glm::u8vec3(50, 60, 70) : glm::u8vec3(7, 8, 9)));
  }
}

// A fan around vertex 0 with `rim` vertices, closed.
Mesh fan(std::uint32_t rim) {
  Mesh mesh;
  mesh.positions.emplace_back(0, 0, 4);
  for (std::uint32_t i = 0; i < rim; ++i) {
    const double angle = 2 * M_PI * i / rim;
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 4);
    mesh.faces.emplace_back(0, 1 + i, 1 + (i + 1) % rim);
  }
  return mesh;
}

TEST_CASE("an unseen vertex between coloured ones has the mean of its neighbours, in linear light") {
  const Mesh mesh = fan(6);
  StoredView white_left = flat_view({255, 255, 255});
  change_photograph(white_left, [](Photograph& photograph) {
    for (std::size_t pixel = 0; pixel < 256; ++pixel) {
      if (pixel % 16 >= 8) std::fill_n(&photograph.rgb[3 * pixel], 3, std::uint8_t{0});
    }
  });
  const glm::dvec2 centre = white_left.camera.image_from_cam(glm::dvec3(mesh.positions[0]));
  own_mask(white_left).validity.values()[16 * static_cast<std::size_t>(centre.y) + static_cast<std::size_t>(centre.x)] =
      0;
  const std::vector<glm::u8vec3> colors = mean_of(mesh, {white_left});
  CHECK(colors[0] == glm::u8vec3(188));  // three of its six neighbours are white, three are black
}

TEST_CASE("colours spread from the nearest coloured vertices, ring by ring") {
  Mesh strip;
  add_wall(strip, 12, 1, 1, 4);  // from x = -6 to 6
  StoredView ends = flat_view({0, 0, 0});
  ends.camera.fx = 4;  // so that the image holds it all
  for (std::size_t pixel = 0; pixel < 256; ++pixel) {
    const std::size_t column = pixel % 16;
    change_photograph(ends, [&](Photograph& photograph) {
      std::fill_n(&photograph.rgb[3 * pixel], 3, static_cast<std::uint8_t>(column < 8 ? 100 : 200));
    });
    if (column > 2 && column < 14) own_mask(ends).validity.values()[pixel] = 0;  // x from -5 to 5
  }
  const std::vector<glm::u8vec3> colors = mean_of(strip, {ends});
  for (std::size_t vertex = 0; vertex < colors.size(); ++vertex) {
    const float x = strip.positions[vertex].x;
    CAPTURE(vertex, x);
    if (x <= -1) CHECK(colors[vertex] == glm::u8vec3(100));
    if (x >= 1) CHECK(colors[vertex] == glm::u8vec3(200));
    if (x == 0) CHECK((colors[vertex].r > 100 && colors[vertex].r < 200));
  }
}

TEST_CASE("a colour reaches the far end of a large mesh without a pass over all of it for each ring") {
  Mesh mesh;
  add_wall(mesh, 700, 700, 0.01f, 4);
  StoredView corner = flat_view({12, 34, 56});
  corner.camera.fx = corner.camera.fy = 16;
  corner.camera.cx = corner.camera.cy = 16 + 16 * 3.499 / 4;  // only the first vertex is in the image
  CHECK(mean_of(mesh, {corner}) == all(mesh, {12, 34, 56}));
}

TEST_CASE("colours of a store need its surface, and a gain for each slot") {
  VertexColors colors;
  CHECK_THROWS_WITH(colors.of(nullptr, {}, {}), Catch::Contains("surface is null"));
  const auto surface = std::make_shared<const Surface>();
  const std::vector<std::shared_ptr<const StoredView>> views(2);
  const std::vector<glm::dvec3> gains(1, glm::dvec3(1));
  CHECK_THROWS_WITH(colors.of(surface, views, gains),
                    Catch::Contains("there are 1 gains") && Catch::Contains("2 slots"));
}

TEST_CASE("a component of which nothing is known is mid-grey") {
  Mesh mesh = wall();
  const std::size_t seen = mesh.positions.size();
  add_wall(mesh, 1, 1, 1, -50);  // behind the camera
  const std::vector<glm::u8vec3> colors = mean_of(mesh, {flat_view({200, 0, 0})});
  for (std::size_t vertex = 0; vertex < colors.size(); ++vertex) {
    CHECK(colors[vertex] == (vertex < seen ? glm::u8vec3(200, 0, 0) : glm::u8vec3(128)));
  }
  CHECK(mean_of(mesh, {}) == all(mesh, glm::u8vec3(128)));
}

}  // namespace
}  // namespace lumatlas
