// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/median_colors.h"

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>

#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

// A photograph to be compared with a gallery's views, and where.
struct Newcomer {
  Newcomer(const Relief& relief, const Camera& where, const glm::dvec3& exposure = glm::dvec3(1.0))
      : camera(where),
        photograph(relief.photograph(where, exposure)),
        pyramid(photograph),
        samples(choose_surface_samples(camera, pyramid, relief.visibility->trace(camera.shrunk_to(160)), 500)) {}
  [[nodiscard]] MedianColors compared_with(const Gallery& gallery, std::optional<ViewSlot> except = {}) const {
    return median_colors(camera, pyramid, samples, gallery.atlas, gallery.views, except);
  }

  Camera camera;
  Photograph photograph;
  Pyramid pyramid;
  std::vector<SurfaceSample> samples;
};

void add_arc(Gallery& gallery, const std::vector<double>& degrees, const glm::dvec3& exposure = glm::dvec3(1.0)) {
  for (const double angle : degrees) {
    const Camera camera = camera_on_arc(angle);
    gallery.add(camera, gallery.relief.photograph(camera, exposure));
  }
}

Photograph flat_photograph(const Camera& camera, std::uint8_t value) {
  return {
      camera.width, camera.height, std::vector<std::uint8_t>(3 * std::size_t{camera.width} * camera.height, value), {}};
}

// Mean over points and channels of the difference from the surface's colour.
double mean_error(const MedianColors& medians) {
  double sum = 0;
  for (std::size_t i = 0; i < medians.targets.positions.size(); ++i) {
    const glm::dvec3 off = glm::dvec3(medians.targets.colors[0][i]) - relief_color(medians.targets.positions[i]);
    sum += (std::abs(off.r) + std::abs(off.g) + std::abs(off.b)) / 3;
  }
  return sum / static_cast<double>(medians.targets.positions.size());
}

TEST_CASE("samples lie on the surface that the camera sees, where their pixels say") {
  const Relief relief;
  const Newcomer newcomer(relief, camera_on_arc(0));
  REQUIRE(newcomer.samples.size() > 300);
  REQUIRE(newcomer.samples.size() <= 600);
  for (const SurfaceSample& sample : newcomer.samples) {
    const glm::dvec3 cam = newcomer.camera.cam_from_world(sample.position);
    REQUIRE(glm::length(newcomer.camera.image_from_cam(cam) - sample.image) < 1e-9);
    REQUIRE(sample.face < relief.surface->mesh.faces.size());
    REQUIRE(sample.position.z > 3.55);
    REQUIRE(sample.position.z < 4.45);
  }
}

TEST_CASE("medians are found at the levels that alignment needs, the same ones as of all levels") {
  Gallery gallery(4);
  add_arc(gallery, {-12, -5, 6, 14});
  const Newcomer newcomer(gallery.relief, camera_on_arc(1));
  const MedianColors all = newcomer.compared_with(gallery);
  AlignmentOptions finest;
  finest.levels = 1;
  finest.exposure = finest.correlation = false;
  const MedianColors few = median_colors(newcomer.camera, newcomer.pyramid, newcomer.samples, gallery.atlas,
                                         gallery.views, std::nullopt, finest);
  REQUIRE(all.targets.colors.size() >= 2);
  REQUIRE(all.targets.positions.size() > 100);
  REQUIRE(few.targets.colors.size() == all.targets.colors.size());
  CHECK(few.targets.positions == all.targets.positions);
  CHECK(few.targets.colors[0] == all.targets.colors[0]);
  for (std::size_t level = 1; level < few.targets.colors.size(); ++level) {
    CHECK(all.targets.colors[level].size() == all.targets.positions.size());
    CHECK(few.targets.colors[level].empty());
  }
  REQUIRE(few.ratios.size() == all.ratios.size());  // whatever level they are of
  for (std::size_t i = 0; i < few.ratios.size(); ++i) CHECK(few.ratios[i].log_luminance == all.ratios[i].log_luminance);
}

TEST_CASE("no sample is on a depth edge, outside the lens's image, black or clipped") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(120, 120);
  const VisibilityBuffer visible = make_ray_visibility(surface->mesh)->trace(camera);
  Photograph photograph = flat_photograph(camera, 120);
  photograph.valid.assign(std::size_t{120} * 120, 255);
  for (std::uint32_t y = 0; y < 120; ++y) {
    for (std::uint32_t x = 0; x < 120; ++x) {
      const std::size_t pixel = std::size_t{y} * 120 + x;
      if (x < 20) photograph.valid[pixel] = 0;
      if (y < 10) photograph.rgb[3 * pixel] = photograph.rgb[3 * pixel + 1] = photograph.rgb[3 * pixel + 2] = 5;
      if (y >= 110) photograph.rgb[3 * pixel + 1] = 255;
    }
  }
  const Pyramid pyramid(photograph);
  const std::vector<SurfaceSample> samples = choose_surface_samples(camera, pyramid, visible, 2000);
  REQUIRE(samples.size() > 500);
  for (const SurfaceSample& sample : samples) {
    REQUIRE(sample.image.x >= 20);
    REQUIRE(sample.image.y >= 10);
    REQUIRE(sample.image.y < 110);
    // The panel's outline: half a unit wide at depth 2, so 30 pixels in the middle.
    const glm::dvec2 off = glm::abs(sample.image - glm::dvec2(60));
    REQUIRE(std::abs(std::max(off.x, off.y) - 15) > 0.5);
  }
}

TEST_CASE("the black under a mask draws no samples towards it") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(120, 120);
  const VisibilityBuffer visible = make_ray_visibility(surface->mesh)->trace(camera);
  Photograph photograph = position_photograph(120, 120);
  photograph.valid.assign(std::size_t{120} * 120, 255);
  Photograph blackened = photograph;
  for (std::uint32_t pixel = 0; pixel < 120 * 120; ++pixel) {
    if (pixel % 120 >= 37 && pixel / 120 >= 13) continue;
    photograph.valid[pixel] = blackened.valid[pixel] = 0;
    for (std::size_t channel = 0; channel < 3; ++channel) blackened.rgb[3 * pixel + channel] = 0;
  }
  const auto images = [&](const Photograph& of) {
    std::vector<glm::dvec2> found;
    for (const SurfaceSample& sample : choose_surface_samples(camera, Pyramid(of), visible, 500)) {
      found.push_back(sample.image);
    }
    return found;
  };
  REQUIRE(images(photograph).size() > 100);
  CHECK(images(blackened) == images(photograph));
}

TEST_CASE("a camera that sees nothing has no samples, and no samples have no medians") {
  Gallery gallery(2);
  add_arc(gallery, {0, 5});
  Camera away = camera_on_arc(0);
  away.cam_from_world_translation = {500, 0, 500};
  const Newcomer lost(gallery.relief, away);
  CHECK(lost.samples.empty());
  const MedianColors medians = lost.compared_with(gallery);
  CHECK(medians.targets.positions.empty());
  CHECK(medians.ratios.empty());
  CHECK(medians.views_per_point == 0);
}

TEST_CASE("an empty gallery has no medians") {
  const Gallery gallery(2);
  const MedianColors medians = Newcomer(gallery.relief, camera_on_arc(0)).compared_with(gallery);
  CHECK(medians.targets.positions.empty());
  CHECK(medians.ratios.empty());
}

TEST_CASE("the medians are the surface's colours, at every level of the photograph") {
  Gallery gallery(5);
  add_arc(gallery, {-12, -6, 0, 6, 12});
  const Newcomer newcomer(gallery.relief, camera_on_arc(3));
  const MedianColors medians = newcomer.compared_with(gallery);
  REQUIRE(medians.targets.positions.size() > 300);
  REQUIRE(medians.targets.colors.size() == newcomer.pyramid.levels());
  for (const auto& colors : medians.targets.colors) CHECK(colors.size() == medians.targets.positions.size());
  CHECK(mean_error(medians) < 0.002);  // 8-bit values, bilinear
  CHECK(medians.views_per_point > 4);
  CHECK(medians.views_per_point <= 5);
}

TEST_CASE("two views of five that show something else leave the medians right") {
  Gallery gallery(5);
  add_arc(gallery, {-6, 0, 6});
  gallery.add(camera_on_arc(4), flat_photograph(camera_on_arc(4), 200));
  gallery.add(camera_on_arc(8), flat_photograph(camera_on_arc(8), 230));
  CHECK(mean_error(Newcomer(gallery.relief, camera_on_arc(0)).compared_with(gallery)) < 0.02);
}

TEST_CASE("gains scale the medians and not the ratios") {
  Gallery gallery(3);
  for (const double angle : {-5.0, 0.0, 5.0}) {
    const Camera camera = camera_on_arc(angle);
    gallery.add(camera, gallery.relief.photograph(camera, glm::dvec3(0.5)), glm::dvec3(2.0));
  }
  const MedianColors medians = Newcomer(gallery.relief, camera_on_arc(2)).compared_with(gallery);
  CHECK(mean_error(medians) < 0.002);
  REQUIRE(medians.ratios.size() == 3);
  for (const ExposureRatio& ratio : medians.ratios) CHECK(ratio.log_luminance.r == Approx(std::log(0.5)).margin(0.01));
}

TEST_CASE("a ratio says how much more light the view recorded than the photograph, channel by channel") {
  Gallery gallery(3);
  gallery.add(camera_on_arc(-4), gallery.relief.photograph(camera_on_arc(-4), {2, 1, 0.5}));
  gallery.add(camera_on_arc(4), gallery.relief.photograph(camera_on_arc(4)));
  const Newcomer newcomer(gallery.relief, camera_on_arc(0), glm::dvec3(0.5));
  const MedianColors medians = newcomer.compared_with(gallery);
  REQUIRE(medians.ratios.size() == 2);
  CHECK(medians.ratios[0].slot == 0);
  CHECK(medians.ratios[0].log_ratio.r == Approx(std::log(4)).margin(0.01));
  CHECK(medians.ratios[0].log_ratio.g == Approx(std::log(2)).margin(0.01));
  CHECK(medians.ratios[0].log_ratio.b == Approx(0).margin(0.01));
  CHECK(medians.ratios[1].slot == 1);
  CHECK(medians.ratios[1].log_luminance.g == Approx(std::log(2)).margin(0.01));
  CHECK(medians.ratios[1].points > 300);
}

TEST_CASE("few points in common make no ratio") {
  Gallery gallery(1);
  add_arc(gallery, {0});
  Newcomer newcomer(gallery.relief, camera_on_arc(2));
  newcomer.samples.resize(19);
  CHECK(newcomer.compared_with(gallery).ratios.empty());
  const Newcomer whole(gallery.relief, camera_on_arc(2));
  newcomer.samples.assign(whole.samples.begin() + 100, whole.samples.begin() + 140);
  CHECK(newcomer.compared_with(gallery).ratios.size() == 1);
}

TEST_CASE("a slot that does not count, a free slot and a view that no cell refers to are left out") {
  Gallery gallery(4);
  add_arc(gallery, {-4, 0, 4});
  const Newcomer newcomer(gallery.relief, camera_on_arc(1));
  const MedianColors without = newcomer.compared_with(gallery, ViewSlot{1});
  REQUIRE(without.ratios.size() == 2);
  CHECK(without.ratios[0].slot == 0);
  CHECK(without.ratios[1].slot == 2);
  for (CellId cell{0}; cell < gallery.relief.surface->cells.cells.size(); ++cell) {
    gallery.atlas.set_references(cell, {2});
  }
  const MedianColors referenced = newcomer.compared_with(gallery);
  REQUIRE(referenced.ratios.size() == 1);
  CHECK(referenced.ratios[0].slot == 2);
  gallery.views[2].reset();
  CHECK(newcomer.compared_with(gallery).targets.positions.empty());
}

TEST_CASE("pixels that are masked, clipped or black say nothing") {
  Gallery gallery(4);
  add_arc(gallery, {0});
  const Camera camera = camera_on_arc(2);
  gallery.add(camera, flat_photograph(camera, 255));
  gallery.add(camera, flat_photograph(camera, 3));
  gallery.add(camera, flat_photograph(camera, 200), glm::dvec3(1.0),
              std::vector<std::uint8_t>(std::size_t{camera.width} * camera.height, 0));
  const MedianColors medians = Newcomer(gallery.relief, camera_on_arc(1)).compared_with(gallery);
  REQUIRE(medians.ratios.size() == 1);
  CHECK(medians.ratios[0].slot == 0);
  CHECK(medians.views_per_point == 1);
}

TEST_CASE("what a view shows of a point before it, behind something, beside its picture or behind itself") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(120, 120);
  const auto stored =
      std::make_shared<const StoredView>(traced_view(*surface, "wall", camera, flat_photograph(camera, 188)));
  const ComparedView view{stored, camera, Pyramid(stored->photograph->span()), glm::dvec3(5.0)};
  const std::optional<glm::dvec3> on_wall = color_in_view(view, {1, 0.4, 4}, 4.0 / 120);
  REQUIRE(on_wall);
  CHECK(on_wall->g == Approx(0.5).margin(0.01));  // without the gain
  CHECK(color_in_view(view, {0.02, 0.03, 2}, 2.0 / 120));
  CHECK_FALSE(color_in_view(view, {0.02, 0.03, 4}, 4.0 / 120));  // behind the panel
  CHECK_FALSE(color_in_view(view, {3, 0, 4}, 4.0 / 120));
  CHECK_FALSE(color_in_view(view, {0, 0, -1}, 4.0 / 120));
  CHECK_FALSE(color_in_view(view, {0, 0, 0}, 4.0 / 120));
  CHECK_FALSE(color_in_view(view, {0.25, 0, 2}, 2.0 / 120));  // on the panel's edge
}

TEST_CASE("a view that was found elsewhere shows its colours there, and what hides them where its depth was made") {
  const auto surface = wall_and_panel();
  const Camera made = forward_camera(120, 120);
  Photograph columns = flat_photograph(made, 0);
  for (std::size_t i = 0; i < columns.rgb.size(); ++i) {
    columns.rgb[i] = static_cast<std::uint8_t>(30 + i / 3 % made.width);
  }
  const auto stored = std::make_shared<const StoredView>(traced_view(*surface, "columns", made, columns));
  const Camera found = forward_camera(120, 120, {0.1, 0, 0});  // 3 pixels away for the wall, 6 for the panel
  const ComparedView view{stored, found, Pyramid(stored->photograph->span()), glm::dvec3(1.0)};
  // The panel's edge is at column 75 of the stored depth. This is 3.6 columns beside it there, and at 75.6 by `found`.
  const std::optional<glm::dvec3> beside = color_in_view(view, {0.62, 0.03, 4}, 4.0 / 120);
  REQUIRE(beside);
  CHECK(beside->g == Approx(view.pyramid.color(0, {75.6, 60.9}).g).epsilon(1e-9));
  // Hidden where depth was made, although `found` would see it beside the panel's left edge.
  CHECK_FALSE(color_in_view(view, {-0.49, 0.03, 4}, 4.0 / 120));
}

TEST_CASE("masks of a view that was found elsewhere are where its colours are") {
  const auto surface = wall_and_panel();
  const Camera made = forward_camera(120, 120);
  const Camera found = forward_camera(120, 120, {0.1, 0, 0});
  const std::size_t pixels = std::size_t{120} * 120;
  // Column 90 is where `found` shows this point, column 93 where `made` does.
  const glm::dvec3 point{1.11, 0.03, 4};
  const auto shows = [&](const std::vector<std::uint8_t>& valid, const std::vector<std::uint8_t>& trust) {
    Photograph photograph = flat_photograph(made, 188);
    photograph.valid = valid;
    const auto stored =
        std::make_shared<const StoredView>(traced_view(*surface, "masked", made, std::move(photograph), {}, trust));
    return color_in_view({stored, found, Pyramid(stored->photograph->span()), glm::dvec3(1.0)}, point, 4.0 / 120)
        .has_value();
  };
  const auto without_column = [&](std::size_t column) {
    std::vector<std::uint8_t> mask(pixels, 255);
    for (std::size_t pixel = column; pixel < pixels; pixel += 120) mask[pixel] = 0;
    return mask;
  };
  CHECK(shows({}, {}));
  CHECK(shows(without_column(87), without_column(87)));
  CHECK_FALSE(shows(without_column(90), {}));
  CHECK_FALSE(shows({}, without_column(90)));
}

TEST_CASE("a coarse comparison reads a coarse level") {
  const auto surface = wall_and_panel();
  const Camera camera = forward_camera(160, 160);
  Photograph stripes = flat_photograph(camera, 0);
  for (std::size_t pixel = 0; pixel < stripes.rgb.size() / 3; pixel += 2) {
    for (std::size_t channel = 0; channel < 3; ++channel) stripes.rgb[3 * pixel + channel] = 255;
  }
  const auto stored = std::make_shared<const StoredView>(traced_view(*surface, "stripes", camera, stripes));
  const ComparedView view{stored, camera, Pyramid(stored->photograph->span()), glm::dvec3(1.0)};
  const glm::dvec3 centre_of_pixel = camera.center() + 4.0 * camera.ray({40.5, 50.5});
  const double fine = color_in_view(view, centre_of_pixel, 4.0 / 160)->r;
  CHECK((fine < 0.01 || fine > 0.99));
  CHECK(color_in_view(view, centre_of_pixel, 2 * 4.0 / 160)->r == Approx(0.5).margin(0.01));
}

TEST_CASE("medians have the same bits on one thread as on four") {
  Gallery gallery(4);
  add_arc(gallery, {-9, -3, 3, 9});
  const Newcomer newcomer(gallery.relief, camera_on_arc(1));
  const auto medians = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return newcomer.compared_with(gallery);
  };
  const MedianColors one = medians(1), four = medians(4);
  CHECK(one.targets.positions == four.targets.positions);
  CHECK(one.targets.colors == four.targets.colors);
  REQUIRE(one.ratios.size() == four.ratios.size());
  for (std::size_t i = 0; i < one.ratios.size(); ++i) CHECK(one.ratios[i].log_ratio == four.ratios[i].log_ratio);
}

}  // namespace
}  // namespace lumatlas
