// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/tracer.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tools/lab/synth/shapes/surface.h"

namespace lumatlas::synth {
namespace {

std::int32_t add_material(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<std::int32_t>(scene.materials.size() - 1);
}

Material plain(float reflectance) {
  Material material;
  material.colors[0] = glm::vec3(reflectance);
  return material;
}

Material shining(const glm::vec3& radiance) {
  Material material;
  material.colors[0] = radiance;
  material.emission = 1;
  return material;
}

// A black hollow cube of side 6 round the origin, without any light.
Scene dark_room() {
  Scene scene;
  Block room;
  BlockPart air{{-3, -3, -3}, {3, 3, 3}, {}};
  air.material.fill(add_material(scene, plain(0)));
  room.parts = {air};
  room.hollow = true;
  scene.solids.emplace_back(room);
  return scene;
}

void add_block(Scene& scene, const glm::dvec3& middle, const glm::dvec3& size, std::int32_t material) {
  Block block;
  block.origin = middle;
  BlockPart part{-0.5 * size, 0.5 * size, {}};
  part.material.fill(material);
  block.parts = {part};
  scene.solids.emplace_back(block);
}

Tracer tracer_of(Scene& scene) {
  scene.geometry = tessellate(scene.solids, 0.7);
  return Tracer(scene);
}

Camera camera_towards(const glm::dvec3& center, const glm::dvec3& target) {
  Camera camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 90;
  camera.fy = 80;
  camera.cx = 31;
  camera.cy = 25.3;
  const glm::dvec3 forward = glm::normalize(target - center);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0.1, 0.2, 1)));
  camera.cam_from_world_rotation = glm::transpose(glm::dmat3(right, glm::cross(forward, right), forward));
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * center);
  return camera;
}

glm::vec3 linear_at(const Photograph& photo, std::uint32_t x, std::uint32_t y) {
  const std::uint8_t* rgb = &photo.rgb[3 * (std::size_t{y} * photo.width + x)];
  return linear_from_srgb(rgb[0], rgb[1], rgb[2]);
}

// Centre of gravity of the red light, in image positions.
glm::dvec2 red_center(const Photograph& photo) {
  glm::dvec2 sum(0.0);
  double weight = 0;
  for (std::uint32_t y = 0; y < photo.height; ++y) {
    for (std::uint32_t x = 0; x < photo.width; ++x) {
      const double red = linear_at(photo, x, y).x;
      sum += red * glm::dvec2(x + 0.5, y + 0.5);
      weight += red;
    }
  }
  REQUIRE(weight > 0);
  return sum / weight;
}

// Centre of gravity of the image of a marker: a square of side kMarker that faces x.
constexpr double kMarker = 0.2;
glm::dvec2 expected_center(const Camera& camera, const glm::dvec3& middle) {
  glm::dvec2 sum(0.0);
  double area = 0;
  glm::dvec2 before = camera.image_from_cam(camera.cam_from_world(middle + kMarker * glm::dvec3(0, -0.5, 0.5)));
  for (const glm::dvec2 turn :
       {glm::dvec2(-0.5, -0.5), glm::dvec2(0.5, -0.5), glm::dvec2(0.5, 0.5), glm::dvec2(-0.5, 0.5)}) {
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(middle + kMarker * glm::dvec3(0, turn)));
    const double cross = before.x * at.y - at.x * before.y;
    sum += cross / 3 * (before + at);
    area += cross;
    before = at;
  }
  return sum / area;
}

TEST_CASE("a marker appears at the position that the camera predicts") {
  Scene scene = dark_room();
  const glm::dvec3 marker(0.3, -0.2, 0.4);
  add_block(scene, marker, glm::dvec3(1e-4, kMarker, kMarker), add_material(scene, shining({0.9F, 0, 0})));
  const Tracer tracer = tracer_of(scene);
  for (const glm::dvec3 center : {glm::dvec3(2.5, 0.4, 0.1), glm::dvec3(2, -1, 1.5), glm::dvec3(-2.3, 0.2, -0.5)}) {
    for (const glm::dvec3 target : {glm::dvec3(0.5, 0.1, 0.2), glm::dvec3(0.2, -0.4, 0.8)}) {
      const Camera camera = camera_towards(center, target);
      const Photograph photo = tracer.photograph(camera, 256, 5);
      CHECK(glm::length(red_center(photo) - expected_center(camera, marker)) < 0.015);  // 256 paths, 8 bits
    }
  }
}

TEST_CASE("a mirror shows a marker at its mirror image") {
  Scene scene = dark_room();
  Material mirror = plain(1);
  mirror.metal = true;
  std::get<Block>(scene.solids[0]).parts[0].material[4] = add_material(scene, mirror);
  const glm::dvec3 marker(0.3, -0.2, -1.9);
  add_block(scene, marker, glm::dvec3(1e-4, kMarker, kMarker), add_material(scene, shining({0.9F, 0, 0})));
  const Tracer tracer = tracer_of(scene);
  const Camera camera = camera_towards({2.5, 0.2, -1.5}, {0.8, -0.1, -3.4});  // the marker itself is out of view
  const Photograph photo = tracer.photograph(camera, 256, 5);
  const glm::dvec3 image(marker.x, marker.y, -6 - marker.z);
  CHECK(glm::length(red_center(photo) - expected_center(camera, image)) < 0.015);
}

// A floor of reflectance 0.6 at z = -3 under a small lamp at height `height` above its middle.
Scene lit_floor(float height) {
  Scene scene = dark_room();
  std::get<Block>(scene.solids[0]).parts[0].material[4] = add_material(scene, plain(0.6F));
  scene.lights.push_back({{-0.05F, -0.05F, height - 3}, {0, 0.1F, 0}, {0.1F, 0, 0}, glm::vec3(200)});
  return scene;
}

TEST_CASE("a small lamp lights a diffuse floor by the inverse square of its distance") {
  for (const float height : {1.5F, 2.0F, 3.0F}) {
    Scene scene = lit_floor(height);
    const Tracer tracer = tracer_of(scene);
    const Camera camera = camera_towards({0, 1, 0}, {0, 0, -3});
    const Photograph photo = tracer.photograph(camera, 64, 1);
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world({0, 0, -3}));
    const float expected = 0.6F * 200 * 0.01F / (std::numbers::pi_v<float> * height * height);
    const glm::vec3 light = linear_at(photo, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y));
    CHECK(light.x == Approx(expected).epsilon(0.02));  // the lamp's size, 8 bits
  }
}

TEST_CASE("what stands between the lamp and the floor casts a shadow, and none elsewhere") {
  Scene scene = lit_floor(2);
  add_block(scene, {0.3, 0, -2.5}, {0.3, 0.3, 0.02}, add_material(scene, plain(0)));
  const Tracer tracer = tracer_of(scene);
  const Camera camera = camera_towards({0, 2, -2.6}, {0.1, 0, -3});
  const Photograph photo = tracer.photograph(camera, 64, 1);
  const auto light_at = [&](const glm::dvec3& p) {
    const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(p));
    return linear_at(photo, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y)).x;
  };
  CHECK(light_at({0.4, 0, -3}) == 0);
  CHECK(light_at({-0.4, 0, -3}) > 0.08);
}

TEST_CASE("a glossy floor looks different from different sides, a dull one the same") {
  for (const float gloss : {0.0F, 0.3F}) {
    Scene scene = lit_floor(2);
    scene.materials.back().gloss = gloss;
    add_block(scene, {-2, 0, -2}, {0.5, 4, 2}, add_material(scene, shining({0.5F, 0, 0})));
    const Tracer tracer = tracer_of(scene);
    const auto red_from = [&](const glm::dvec3& center) {
      const Camera camera = camera_towards(center, {0, 0, -3});
      return linear_at(tracer.photograph(camera, 64, 1), 31, 25).x;
    };
    const float difference = red_from({2, 0, -2}) - red_from({0, 2, -2});
    if (gloss > 0) CHECK(difference > 0.1F);
    if (gloss == 0) CHECK(std::abs(difference) < 0.02F);
  }
}

TEST_CASE("ambient light fills the open and fades in corners") {
  Scene scene = dark_room();
  scene.ambient_above = scene.ambient_below = glm::vec3(0.5F);
  scene.solids.pop_back();
  Block room;
  BlockPart air{{-3, -3, -3}, {3, 3, 3}, {}};
  air.material.fill(add_material(scene, plain(0.8F)));
  room.parts = {air};
  room.hollow = true;
  scene.solids.emplace_back(room);
  const Tracer tracer = tracer_of(scene);
  const Camera open = camera_towards({0, 0, 0}, {3, 0, 0});
  CHECK(linear_at(tracer.photograph(open, 16, 1), 31, 25).x == Approx(0.4).epsilon(0.01));  // 8 bits
  const Camera corner = camera_towards({0, 0, 0}, {3, 3, 3});
  CHECK(linear_at(tracer.photograph(corner, 64, 1), 31, 25).x < 0.3F);
}

TEST_CASE("a tracer refuses a bad camera and no samples") {
  Scene scene = dark_room();
  const Tracer tracer = tracer_of(scene);
  CHECK_THROWS_WITH(tracer.photograph(camera_towards({1, 0, 0}, {0, 0, 0}), 0, 1),
                    "tracer: samples is 0, must be at least 1");
  CHECK_THROWS_AS(tracer.photograph(Camera{}, 1, 1), std::invalid_argument);
}

TEST_CASE("a tracer sees between points unless a surface is in the way") {
  Scene scene = dark_room();
  add_block(scene, {0, 0, 0}, {0.5, 0.5, 0.5}, 0);
  const Tracer tracer = tracer_of(scene);
  CHECK_FALSE(tracer.sees({-2, 0, 0}, {2, 0, 0}));
  CHECK(tracer.sees({-2, 0, 0}, {-0.25, 0, 0}));
  CHECK(tracer.sees({-2, 1, 0}, {2, 1, 0}));
}

// Mean and standard deviation of one channel of a photograph, in levels.
std::pair<double, double> levels(const Photograph& photo, std::size_t channel) {
  double sum = 0;
  double squares = 0;
  for (std::size_t i = channel; i < photo.rgb.size(); i += 3) {
    sum += photo.rgb[i];
    squares += photo.rgb[i] * photo.rgb[i];
  }
  const double count = static_cast<double>(photo.rgb.size()) / 3;
  return {sum / count, std::sqrt(squares / count - sum * sum / (count * count))};
}

// If all sides shine alike, the sensor gets the same at all pixels.
Photograph of_shining_room(const glm::vec3& light, double noise) {
  Scene scene = dark_room();
  std::get<Block>(scene.solids[0]).parts[0].material.fill(add_material(scene, shining(light)));
  const Tracer tracer = tracer_of(scene);
  Camera camera = camera_towards({0, 0, 0}, {1, 0, 0});
  camera.width = 200;
  camera.height = 150;
  return tracer.photograph(camera, 1, 3, {glm::vec3(1), 0, noise, {}});
}

TEST_CASE("sensor noise has the stated deviation at mid grey, in each channel by itself") {
  const glm::vec3 grey = linear_from_srgb(128, 128, 128);
  CHECK(levels(of_shining_room(grey, 0), 0).second == 0);
  for (const double noise : {1.0, 5.0, 12.0}) {
    const Photograph photo = of_shining_room(grey, noise);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      const auto [mean, deviation] = levels(photo, channel);
      // 30000 pixels: 0.4 % standard error; rounding adds a variance of 1/12, the curve of sRGB more
      // the further the noise reaches.
      CHECK(deviation == Approx(std::sqrt(noise * noise + 1.0 / 12)).epsilon(0.01 + 0.002 * noise));
      CHECK(std::abs(mean - 128) < 0.1 + 0.007 * noise * noise);
    }
    double products = 0;
    for (std::size_t i = 0; i < photo.rgb.size(); i += 3)
      products += (photo.rgb[i] - 128.0) * (photo.rgb[i + 1] - 128.0);
    CHECK(std::abs(products / 30000) < 0.05 * noise * noise + 0.05);
  }
}

TEST_CASE("sensor noise is that of photons where it is bright, and the sensor's own in the dark") {
  const auto variance = [](float light) {  // of the linear light, whose slope over sRGB is known
    const double deviation = levels(of_shining_room(glm::vec3(light), 4), 1).second;
    const double slope = 255 * 1.055 / 2.4 * std::pow(static_cast<double>(light), 1 / 2.4 - 1);
    return std::pow(deviation / slope, 2);
  };
  // Shot noise grows with the light; 2 % of the variance at mid grey, 0.216, do not.
  CHECK(variance(0.5F) / variance(0.1F) ==
        Approx((0.02 + 0.98 * 0.5 / 0.216) / (0.02 + 0.98 * 0.1 / 0.216)).epsilon(0.06));
  const Photograph dark = of_shining_room(glm::vec3(0.0F), 4);
  CHECK(levels(dark, 0).second > 1);
}

// Second moments of the red light, pixels squared.
glm::dvec2 red_variance(const Photograph& photo) {
  const glm::dvec2 center = red_center(photo);
  glm::dvec2 sum(0.0);
  double weight = 0;
  for (std::uint32_t y = 0; y < photo.height; ++y) {
    for (std::uint32_t x = 0; x < photo.width; ++x) {
      const glm::dvec2 off = glm::dvec2(x + 0.5, y + 0.5) - center;
      sum += static_cast<double>(linear_at(photo, x, y).x) * off * off;
      weight += linear_at(photo, x, y).x;
    }
  }
  return sum / weight;
}

TEST_CASE("a camera that turns while its shutter is open draws a point out to a line as long as the turn") {
  Scene scene = dark_room();
  add_block(scene, {0, 0, 0}, glm::dvec3(1e-4, kMarker, kMarker), add_material(scene, shining({0.5F, 0, 0})));
  const Tracer tracer = tracer_of(scene);
  const Camera camera = camera_towards({2.5, 0, 0}, {0, 0, 0});
  const Photograph sharp = tracer.photograph(camera, 256, 5);
  for (const double pixels : {4.0, 16.0}) {
    Exposure exposure;
    exposure.motion.rotation = {0, 2 * std::atan(0.5 * pixels / camera.fx), 0};  // about the picture's upright axis
    const Photograph blurred = tracer.photograph(camera, 256, 5, exposure);
    const glm::dvec2 grown = red_variance(blurred) - red_variance(sharp);
    CHECK(std::sqrt(12 * grown.x) == Approx(pixels).epsilon(0.05));  // a line of length l has the variance l^2 / 12
    CHECK(std::abs(grown.y) < 0.1);
    CHECK(glm::length(red_center(blurred) - red_center(sharp)) < 0.1);  // as much before the pose as after
  }
}

TEST_CASE("a visitor looks like the same solid of the scene, shadow included, and is not seen without") {
  const glm::dvec3 middle(0.3, 0, -2.4);
  const glm::dvec3 size(0.3, 0.3, 0.3);
  Scene with = lit_floor(2);
  Scene without = with;
  add_block(with, middle, size, add_material(with, plain(0.4F)));
  const Tracer expected = tracer_of(with);
  const Tracer tracer = tracer_of(without);
  const Camera camera = camera_towards({0, 2, -2}, {0.1, 0, -2.9});
  const Photograph empty = tracer.photograph(camera, 8, 1);
  const Solid block = with.solids.back();
  const Visitor visitor = tracer.visitor(std::vector<Solid>{block}, with.materials);
  const Photograph a = expected.photograph(camera, 8, 1);
  const Photograph b = tracer.photograph(camera, 8, 1, {}, &visitor);
  std::size_t different = 0;  // a ray at an edge may go the other way by rounding
  for (std::size_t i = 0; i < a.rgb.size(); ++i) different += std::abs(a.rgb[i] - b.rgb[i]) > 2 ? 1 : 0;
  CHECK(different < a.rgb.size() / 100);
  CHECK(a.rgb != empty.rgb);
  CHECK(tracer.photograph(camera, 8, 1).rgb == empty.rgb);
  const glm::dvec2 at = camera.image_from_cam(camera.cam_from_world(middle));
  const Photograph mask = tracer.mask(camera, visitor);
  CHECK(linear_at(mask, static_cast<std::uint32_t>(at.x), static_cast<std::uint32_t>(at.y)).x == 1);
  CHECK(linear_at(mask, 0, 0).x == 0);
}

TEST_CASE("a visitor is in the way of what it hides, and hidden by what is in its way") {
  Scene scene = dark_room();
  add_block(scene, {1, 0, 0}, {0.1, 1, 1}, 0);
  const Tracer tracer = tracer_of(scene);
  Scene other = dark_room();
  add_block(other, {-1, 0, 0}, {0.5, 0.5, 0.5}, 0);
  const Visitor visitor = tracer.visitor(std::vector<Solid>{other.solids.back()}, other.materials);
  CHECK(tracer.sees({-2, 0, 0}, {0, 0, 0}));
  CHECK_FALSE(tracer.sees({-2, 0, 0}, {0, 0, 0}, &visitor));
  const Photograph hidden = tracer.mask(camera_towards({2.5, 0, 0}, {0, 0, 0}), visitor);
  CHECK(linear_at(hidden, 31, 25).x == 0);
}

TEST_CASE("the point that an image position shows is on the surface and on the ray") {
  Scene scene = dark_room();
  const Tracer tracer = tracer_of(scene);
  const Camera camera = camera_towards({2, 0.5, 1}, {-3, 0, 0});
  const std::optional<glm::dvec3> point = tracer.surface_at(camera, {20, 30});
  REQUIRE(point);
  CHECK(point->x == Approx(-3));
  CHECK(glm::length(camera.image_from_cam(camera.cam_from_world(*point)) - glm::dvec2(20, 30)) < 1e-4);  // float rays
}

TEST_CASE("8-bit sRGB survives the way through linear light") {
  for (int value = 0; value < 256; ++value) CHECK(srgb_from_linear(linear_from_srgb(value, 0, 0).x) == value);
  CHECK(srgb_from_linear(-1) == 0);
  CHECK(srgb_from_linear(7) == 255);
  CHECK(srgb_from_linear(0.5F) == 188);  // 1.055 * 0.5^(1 / 2.4) - 0.055 = 0.7354
}

TEST_CASE("every pattern is a reflectance that differs from its mirror images") {
  for (int which = 1; which <= static_cast<int>(Pattern::foliage); ++which) {
    Material material;
    material.pattern = static_cast<Pattern>(which);
    material.colors = {glm::vec3(0.6F, 0.5F, 0.3F), glm::vec3(0.2F, 0.3F, 0.4F), glm::vec3(0.1F, 0.05F, 0.3F)};
    material.seed = 77;
    material.scale = 0.2F;
    const glm::vec2 size(1.2F, 0.9F);
    double flipped_s = 0;
    double flipped_t = 0;
    for (float s = 0.013F; s < size.x; s += 0.031F) {
      for (float t = 0.011F; t < size.y; t += 0.029F) {
        const glm::vec3 color = pattern_color(material, {s, t}, size);
        CHECK((glm::all(glm::greaterThanEqual(color, glm::vec3(0))) &&
               glm::all(glm::lessThanEqual(color, glm::vec3(1.15F)))));
        flipped_s += glm::distance(color, pattern_color(material, {size.x - s, t}, size)) / 1200;
        flipped_t += glm::distance(color, pattern_color(material, {s, size.y - t}, size)) / 1200;
      }
    }
    INFO("pattern " << which);
    CHECK(flipped_s > 0.01);
    CHECK(flipped_t > 0.01);
  }
}

}  // namespace
}  // namespace lumatlas::synth
