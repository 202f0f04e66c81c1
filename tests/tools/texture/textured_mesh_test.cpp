// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/textured_mesh.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "atlas/images/srgb.h"
#include "mesh/base/errors.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/scenes/small_scenes.h"

namespace lumatlas {
namespace {

using glm::dvec3;

struct Baked {
  std::vector<Photograph> pages;
  TextureFacts facts;
};

Baked bake(const TexturedMesh& mesh) {
  Baked baked;
  baked.facts = mesh.bake([&](std::uint32_t page, const Photograph& picture) {
    REQUIRE(page == baked.pages.size());
    baked.pages.push_back(picture);
  });
  return baked;
}

// Samples as a viewer does, between four texels; 8-bit levels.
dvec3 sampled(const TexturedMesh& mesh, const Baked& baked, std::uint32_t face, const dvec3& point) {
  const std::uint32_t chart = mesh.chart_of_face()[face];
  const ChartPlace& place = mesh.layout().places[chart];
  const Photograph& page = baked.pages[place.page];
  const glm::vec2 uv = mesh.layout().uv(mesh.charts()[chart], place, point);
  REQUIRE((uv.x > 0 && uv.x < 1 && uv.y > 0 && uv.y < 1));
  const glm::dvec2 at = glm::dvec2(uv) * static_cast<double>(page.width) - 0.5;
  const glm::dvec2 base = glm::floor(at), f = at - base;
  dvec3 sum(0);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::size_t right = corner % 2, below = corner / 2;
    const std::size_t texel =
        (static_cast<std::size_t>(base.y) + below) * page.width + static_cast<std::size_t>(base.x) + right;
    const double share = (right == 1 ? f.x : 1 - f.x) * (below == 1 ? f.y : 1 - f.y);
    for (std::size_t c = 0; c < 3; ++c) sum[static_cast<int>(c)] += share * page.rgb[3 * texel + c];
  }
  return sum;
}

double worst(const dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

dvec3 levels_of(const dvec3& linear) {
  dvec3 levels;
  for (int c = 0; c < 3; ++c) levels[c] = 255 * srgb_from_linear(linear[c]);
  return levels;
}

dvec3 middle_of(const Mesh& mesh, std::uint32_t face) {
  const glm::uvec3& f = mesh.faces[face];
  return (dvec3(mesh.positions[f.x]) + dvec3(mesh.positions[f.y]) + dvec3(mesh.positions[f.z])) / 3.0;
}

// Faces in the middle of the relief, which all cameras on the arc see.
bool is_inside(const dvec3& point) {
  return std::abs(point.x) < 1.2 && std::abs(point.y) < 0.9;
}

// Colours as they are on the relief, without the photographs' exposures.
TextureOptions in_model_exposure() {
  TextureOptions options;
  options.color.exposure = ColorOptions::Exposure::model;
  return options;
}

// Seven photographs along an arc before the relief, with their own exposures, which the gains take away.
Snapshot arc_snapshot(const Shading& shading) {
  Gallery gallery(7);
  const std::array<double, 7> exposures{1, 0.7, 1.6, 1, 1.3, 0.8, 1.1};
  for (std::size_t i = 0; i < 7; ++i) {
    const Camera camera = camera_on_arc(-30 + 10.0 * static_cast<double>(i));
    gallery.add(camera, gallery.relief.photograph(camera, dvec3(exposures[i]), shading), dvec3(1 / exposures[i]));
  }
  return gallery.atlas.snapshot();
}

TEST_CASE("a scene of one colour has a texture of that colour, whatever the exposures") {
  const dvec3 gray(0.2, 0.3, 0.1);
  const TexturedMesh mesh(arc_snapshot([&](const dvec3&, const dvec3&) { return gray; }), in_model_exposure());
  const Baked baked = bake(mesh);
  CHECK(baked.facts.texels_per_pixel == 1);
  std::size_t inside = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (!is_inside(point)) continue;
    ++inside;
    REQUIRE(worst(sampled(mesh, baked, face, point) - levels_of(gray)) <= 1.5);  // rounded in photograph and texture
  }
  CHECK(inside > 300);
}

TEST_CASE("a pattern comes back where it was") {
  const TexturedMesh mesh(arc_snapshot(plain_shading()), in_model_exposure());
  const Baked baked = bake(mesh);
  double squares = 0, count = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (!is_inside(point)) continue;
    const dvec3 off = sampled(mesh, baked, face, point) - levels_of(relief_color(point));
    REQUIRE(worst(off) < 8);  // waves of 14 pixels, between pixels and then between texels
    squares += glm::dot(off, off) / 3;
    ++count;
  }
  CHECK(std::sqrt(squares / count) < 1.5);
}

TEST_CASE("a highlight that moves with the camera is left out") {
  // A bright spot of 0.8 scene units where the camera's mirror image would be.
  const auto glossy = [](const dvec3& point, const dvec3& center) {
    const double away = glm::length(glm::dvec2(point.x - 0.5 * center.x, point.y - 0.5 * center.y));
    return relief_color(point) + dvec3(0.6 * std::exp(-away * away / 0.08));
  };
  const TexturedMesh mesh(arc_snapshot(glossy), in_model_exposure());
  const Baked baked = bake(mesh);
  double squares = 0, of_mean = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (!is_inside(point)) continue;
    const dvec3 off = sampled(mesh, baked, face, point) - levels_of(relief_color(point));
    dvec3 mean(0);
    for (int i = 0; i < 7; ++i) mean += glossy(point, camera_on_arc(-30 + 10.0 * i).center()) / 7.0;
    const dvec3 mean_off = levels_of(mean) - levels_of(relief_color(point));
    squares += glm::dot(off, off);
    of_mean += glm::dot(mean_off, mean_off);
  }
  CHECK(std::sqrt(squares / of_mean) < 0.5);
}

TEST_CASE("what no photograph shows has the vertices' colours and is counted") {
  Gallery gallery(1);
  const Camera camera = relief_camera({-2, 0, 1}, {-2, 0, 4});  // its picture is 3.75 wide at depth 3
  gallery.add(camera, gallery.relief.photograph(camera));
  const Snapshot snapshot = gallery.atlas.snapshot();
  const TexturedMesh mesh(snapshot, {});
  const Baked baked = bake(mesh);
  CHECK(baked.facts.unseen_texels > baked.facts.texels / 20);
  CHECK(baked.facts.unseen_texels < baked.facts.texels / 2);
  std::size_t unseen = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (point.x < 1) continue;
    ++unseen;
    dvec3 mean(0);
    for (int c = 0; c < 3; ++c) {
      const glm::u8vec3 vertex = snapshot.vertex_colors.get()[mesh.mesh().faces[face][c]];
      for (int channel = 0; channel < 3; ++channel) mean[channel] += linear_from_srgb(vertex[channel] / 255.0) / 3;
    }
    REQUIRE(worst(sampled(mesh, baked, face, point) - levels_of(mean)) < 5);  // at an eighth of the density
  }
  CHECK(unseen > 1000);
}

TEST_CASE("charts meet without a seam") {
  TextureOptions options;
  options.charts.merge_degrees = 6;  // many charts
  const TexturedMesh mesh(arc_snapshot(plain_shading()), options);
  REQUIRE(mesh.charts().size() > 20);
  const Baked baked = bake(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> face_of_edge;
  double squares = 0, count = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    for (int c = 0; c < 3; ++c) {
      const std::uint32_t from = mesh.mesh().faces[face][c], to = mesh.mesh().faces[face][(c + 1) % 3];
      face_of_edge[{from, to}] = face;
      const auto other = face_of_edge.find({to, from});
      if (other == face_of_edge.end()) continue;
      if (mesh.chart_of_face()[face] == mesh.chart_of_face()[other->second]) continue;
      if (mesh.layout().places[mesh.chart_of_face()[face]].density < 20) continue;  // nobody sees it
      const dvec3 point = 0.5 * (dvec3(mesh.mesh().positions[from]) + dvec3(mesh.mesh().positions[to]));
      const dvec3 step = sampled(mesh, baked, face, point) - sampled(mesh, baked, other->second, point);
      CHECK(worst(step) < 8);  // half a texel of the steepest pattern, on either side
      squares += glm::dot(step, step) / 3;
      ++count;
    }
  }
  REQUIRE(count > 200);
  CHECK(std::sqrt(squares / count) < 1);
}

TEST_CASE("the same bytes for any number of threads, also over several pages") {
  TextureOptions options;
  options.layout.most_side_px = 256;
  options.layout.most_pages = 3;
  options.charts.merge_degrees = 10;
  const Snapshot snapshot = room_snapshot(12, {});
  std::vector<Baked> all;
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    all.push_back(bake(TexturedMesh(snapshot, options)));
  }
  CHECK(all[0].pages.size() > 1);
  for (const Baked& one : all) {
    REQUIRE(one.pages.size() == all[0].pages.size());
    CHECK(one.facts.unseen_texels == all[0].facts.unseen_texels);
    for (std::size_t page = 0; page < one.pages.size(); ++page) CHECK(one.pages[page].rgb == all[0].pages[page].rgb);
  }
}

TEST_CASE("each place is exposed as the photographs that see it, smoothly along the surface") {
  const dvec3 gray(0.2, 0.3, 0.1);
  // On the left at half the exposure, on the right at twice.
  Gallery gallery(2);
  for (const double side : {-1.0, 1.0}) {
    const Camera camera = relief_camera({3 * side, 0, 1}, {3 * side, 0, 4});
    const dvec3 exposure(std::exp2(side));
    gallery.add(camera, gallery.relief.photograph(camera, exposure, [&](const dvec3&, const dvec3&) { return gray; }),
                1.0 / exposure);
  }
  const TexturedMesh mesh(gallery.atlas.snapshot(), {});
  const Baked baked = bake(mesh);
  std::array<std::size_t, 2> count{};
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    const dvec3 shown = sampled(mesh, baked, face, point);
    for (int c = 0; c < 3; ++c) {
      REQUIRE(shown[c] > levels_of(gray / 2.0)[c] - 2);
      REQUIRE(shown[c] < levels_of(gray * 2.0)[c] + 2);
    }
    if (std::abs(point.x) < 2.7 || std::abs(point.y) > 0.7) continue;
    ++count[point.x > 0];
    CHECK(worst(shown - levels_of(gray * (point.x > 0 ? 2.0 : 0.5))) < 4);
  }
  CHECK(std::min(count[0], count[1]) > 20);
  // Photographs of one exposure are shown as in the model's.
  const Snapshot plain = room_snapshot(6, {});
  const Baked nearby = bake(TexturedMesh(plain, {})), model = bake(TexturedMesh(plain, in_model_exposure()));
  CHECK(nearby.pages.at(0).rgb == model.pages.at(0).rgb);
}

TEST_CASE("tiles that are not in the model are not shown") {
  TileOptions tiles;
  tiles.tile_px = 32;
  Snapshot snapshot = room_snapshot(6, {}, tiles);
  const Baked whole = bake(TexturedMesh(snapshot, {}));
  std::fill(snapshot.tiles.places.begin(), snapshot.tiles.places.end(), TilePlace::none);
  leave_out_views_without_tiles(snapshot);
  const Baked none = bake(TexturedMesh(snapshot, {}));
  CHECK(whole.facts.unseen_texels < whole.facts.texels);
  CHECK(none.facts.unseen_texels == none.facts.texels);
}

// Seven photographs along an arc before the relief with their own exposures. The first `stored` of an order that goes
// from the middle outwards are in the model.
struct Offered {
  Snapshot snapshot;
  OfferedPhotographs photographs;
  std::vector<std::size_t> reads;  // of each
};

std::shared_ptr<Offered> offered_arc(std::uint32_t stored, const Shading& shading) {
  const std::array<double, 7> degrees{0, -10, 10, -20, 20, -30, 30}, exposures{1, 0.7, 1.6, 1, 1.3, 0.8, 1.1};
  const auto offered = std::make_shared<Offered>();
  Gallery gallery(stored);
  const auto pictures = std::make_shared<std::vector<Photograph>>();
  for (std::uint32_t i = 0; i < degrees.size(); ++i) {
    const Camera camera = camera_on_arc(degrees[i]);
    pictures->push_back(gallery.relief.photograph(camera, dvec3(exposures[i]), shading));
    if (i < stored) gallery.add(camera, pictures->back(), dvec3(1 / exposures[i]));
    offered->photographs.list.push_back({"view " + std::to_string(i), camera});
  }
  offered->snapshot = gallery.atlas.snapshot();
  offered->reads.assign(degrees.size(), 0);
  const auto at_once = std::make_shared<std::atomic<int>>(0);
  offered->photographs.read = [pictures, at_once, seen = offered.get()](std::size_t number) {
    if (at_once->fetch_add(1) != 0) throw InputError("two photographs are read at once");
    ++seen->reads[number];
    Photograph picture = (*pictures)[number];
    at_once->fetch_sub(1);
    return picture;
  };
  return offered;
}

TEST_CASE("photographs that are not in the model come one at a time, and as often as there are batches of texels") {
  const auto offered = offered_arc(3, plain_shading());
  for (const std::uint64_t most : {1u << 24, 6000u}) {
    TextureOptions options;
    options.layout.most_side_px = 128;
    options.layout.most_pages = 2;
    options.most_texels_at_once = most;
    offered->reads.assign(7, 0);
    const TexturedMesh mesh(offered->snapshot, options, offered->photographs);
    std::atomic<std::size_t> ticks = 0;
    const TextureFacts facts = mesh.bake([](std::uint32_t, const Photograph&) {}, [&] { ++ticks; });
    CHECK(ticks == mesh.ticks());
    CHECK(facts.photographs == 7);
    CHECK(facts.outliers == 0);
    const std::size_t rounds = mesh.ticks() / 7;
    if (most > 6000) CHECK(rounds == 1 + mesh.layout().pages);
    if (most == 6000) CHECK(rounds > 1 + mesh.layout().pages);
    CHECK(offered->reads == std::vector<std::size_t>{0, 0, 0, rounds, rounds, rounds, rounds});
  }
}

TEST_CASE("from all photographs, a scene of one colour has that colour, whatever their exposures") {
  const dvec3 gray(0.2, 0.3, 0.1);
  const auto offered = offered_arc(2, [&](const dvec3&, const dvec3&) { return gray; });
  const TexturedMesh mesh(offered->snapshot, in_model_exposure(), offered->photographs);
  const Baked baked = bake(mesh);
  std::size_t inside = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (!is_inside(point)) continue;
    ++inside;
    REQUIRE(worst(sampled(mesh, baked, face, point) - levels_of(gray)) <= 2);  // an exposure found from rounded values
  }
  CHECK(inside > 300);
}

TEST_CASE("photographs that are not in the model show what those in it do not, where it is") {
  const auto offered = offered_arc(1, plain_shading());
  const Baked stored = bake(TexturedMesh(offered->snapshot, {}));
  const TexturedMesh mesh(offered->snapshot, in_model_exposure(), offered->photographs);
  const Baked all = bake(mesh);
  CHECK(static_cast<double>(all.facts.unseen_texels) / static_cast<double>(all.facts.texels) <
        0.7 * static_cast<double>(stored.facts.unseen_texels) / static_cast<double>(stored.facts.texels));
  double squares = 0, count = 0;
  for (std::uint32_t face = 0; face < mesh.mesh().faces.size(); ++face) {
    const dvec3 point = middle_of(mesh.mesh(), face);
    if (!is_inside(point)) continue;
    const dvec3 off = sampled(mesh, all, face, point) - levels_of(relief_color(point));
    squares += glm::dot(off, off) / 3;
    ++count;
  }
  CHECK(std::sqrt(squares / count) < 2);
}

TEST_CASE("from all photographs, those that show something else are left out") {
  const auto offered = offered_arc(4, plain_shading());
  const auto read = offered->photographs.read;
  const Relief relief;
  const Photograph other = relief.photograph(camera_on_arc(30), dvec3(1), [](const dvec3& point, const dvec3&) {
    return relief_color(1.7 * dvec3(point.y, point.x, point.z) + 9.0);
  });
  offered->photographs.read = [=](std::size_t number) { return number == 6 ? other : read(number); };
  const TextureFacts facts = bake(TexturedMesh(offered->snapshot, {}, offered->photographs)).facts;
  CHECK(facts.photographs == 6);
  CHECK(facts.outliers == 1);
  // One of another size is not of this scene.
  offered->photographs.read = [=](std::size_t number) {
    Photograph picture = read(number);
    if (number == 5) picture = {picture.width / 2, picture.height, {}, {}};
    return picture;
  };
  CHECK_THROWS_WITH(bake(TexturedMesh(offered->snapshot, {}, offered->photographs)),
                    Catch::StartsWith("view 5: is 120x180 pixels, but 240x180 in the model"));
}

TEST_CASE("from all photographs, the same bytes for any number of threads and of texels at once") {
  const auto offered = offered_arc(3, plain_shading());
  TextureOptions options;
  options.layout.most_side_px = 192;
  options.layout.most_pages = 3;
  options.charts.merge_degrees = 6;
  std::vector<Baked> all;
  for (const std::size_t threads : {1u, 2u}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    options.most_texels_at_once = threads == 1 ? 1u << 24 : 20000;
    all.push_back(bake(TexturedMesh(offered->snapshot, options, offered->photographs)));
  }
  REQUIRE(all[0].pages.size() == all[1].pages.size());
  CHECK(all[0].facts.unseen_texels == all[1].facts.unseen_texels);
  for (std::size_t page = 0; page < all[0].pages.size(); ++page)
    CHECK(all[0].pages[page].rgb == all[1].pages[page].rgb);
}

TEST_CASE("texture options are refused by name") {
  using Options = TextureOptions;
  CHECK(refusal<Options>([](Options&) {}) == "accepted");
  CHECK(refusal<Options>([](Options& o) { o.texels_per_pixel = 0; }) ==
        "texture: texels_per_pixel is 0, must be above 0 and at most 4");
  CHECK(refusal<Options>([](Options& o) { o.color.sharpness = 17; }) == "texture: sharpness is 17, must be in [0, 16]");
  CHECK(refusal<Options>([](Options& o) { o.color.tolerance = 0; }) ==
        "texture: tolerance is 0, must be finite and above 0");
  CHECK(refusal<Options>([](Options& o) { o.layout.most_pages = 0; }) ==
        "texture: most_pages is 0, must be in [1, 64]");
  CHECK(refusal<Options>([](Options& o) { o.most_texels_at_once = 0; }) ==
        "texture: most_texels_at_once is 0, must be at least 1");
  const Snapshot snapshot = room_snapshot(2, {});
  OfferedPhotographs unreadable;
  unreadable.list.push_back({"a", room_camera(0)});
  CHECK_THROWS_WITH(TexturedMesh(snapshot, {}, unreadable), "texture: photographs are listed, but read is empty");
}

}  // namespace
}  // namespace lumatlas
