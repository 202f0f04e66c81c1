// SPDX-License-Identifier: GPL-3.0-or-later
// The base texture that a build puts into a model's file.
#include "tools/pipeline/surface/baked_texture.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "atlas/images/srgb.h"
#include "atlas/model/model_file.h"
#include "tests/support/scenes/relief_scenes.h"
#include "tests/support/temporary_folder.h"
#include "tools/lab/synth/synth.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/output/save_model.h"

namespace lumatlas {
namespace {

// Seven photographs along an arc before a relief whose colours say where they are.
Snapshot relief_snapshot() {
  Gallery gallery(7);
  for (std::size_t i = 0; i < 7; ++i) {
    const Camera camera = camera_on_arc(-30 + 10.0 * static_cast<double>(i));
    gallery.add(camera, gallery.relief.photograph(camera, glm::dvec3(1), plain_shading()));
  }
  return gallery.atlas.snapshot();
}

// Samples as a viewer does, between four texels; 8-bit levels.
glm::dvec3 sampled(const BaseTexture& texture, const glm::dvec2& share) {
  const Photograph& image = texture.image;
  const glm::dvec2 at = share * glm::dvec2(image.width, image.height) - 0.5;
  const glm::dvec2 base = glm::floor(at), f = at - base;
  glm::dvec3 sum(0);
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const std::size_t right = corner % 2, below = corner / 2;
    const std::size_t texel =
        (static_cast<std::size_t>(base.y) + below) * image.width + static_cast<std::size_t>(base.x) + right;
    const double weight = (right == 1 ? f.x : 1 - f.x) * (below == 1 ? f.y : 1 - f.y);
    for (std::size_t c = 0; c < 3; ++c) sum[static_cast<int>(c)] += weight * image.rgb[3 * texel + c];
  }
  return sum;
}

double worst(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

TEST_CASE("each face lies where the base texture shows its colour, inside of it") {
  const Snapshot snapshot = relief_snapshot();
  const BakedTexture baked = bake_texture(snapshot, 2048);
  const Mesh& mesh = snapshot.surface->mesh;
  REQUIRE(baked.texture.faces.size() == mesh.faces.size());
  CHECK_NOTHROW(check(baked.texture, mesh.faces.size()));
  std::size_t inside = 0, right = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    glm::dvec3 point(0);
    glm::dvec2 place(0);
    for (int corner = 0; corner < 3; ++corner) {
      point += glm::dvec3(mesh.positions[mesh.faces[face][corner]]) / 3.0;
      place += glm::dvec2(baked.texture.faces[face][static_cast<std::size_t>(corner)]) / 3.0;
    }
    if (std::abs(point.x) >= 1.2 || std::abs(point.y) >= 0.9) continue;  // which not all cameras see
    ++inside;
    glm::dvec3 expected;
    const glm::dvec3 color = relief_color(point);
    for (int c = 0; c < 3; ++c) expected[c] = 255 * srgb_from_linear(color[c]);
    right += worst(sampled(baked.texture, place) - expected) < 16;  // waves of 7 texels, and a mean over a texel
  }
  REQUIRE(inside > 300);
  CHECK(100 * right > 98 * inside);
}

TEST_CASE("a base texture has at most the side that is asked for, and the same bytes on 1 and 2 threads") {
  const Snapshot snapshot = relief_snapshot();
  const auto baked_on = [&](std::size_t threads, std::uint32_t side_px) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return bake_texture(snapshot, side_px);
  };
  for (const std::uint32_t side_px : {128u, 200u, 2048u}) {
    CAPTURE(side_px);
    const BakedTexture one = baked_on(1, side_px), two = baked_on(2, side_px);
    CHECK(one.texture.image.width <= side_px);
    CHECK(one.texture.image.height == one.texture.image.width);
    CHECK((one.texture.image.rgb == two.texture.image.rgb));
    CHECK((one.texture.faces == two.texture.faces));
    CHECK(one.texels_per_pixel <= 0.5);
  }
  CHECK_THROWS_AS(bake_texture(snapshot, kLeastTexturePx - 1), std::invalid_argument);
  CHECK_THROWS_AS(bake_texture(snapshot, kMostTexturePx + 1), std::invalid_argument);
}

TEST_CASE("a callback ends the baking of a base texture") {
  const BuildCallback stop = [](const BuildProgress& progress) { return progress.done == 0; };
  CHECK_THROWS_AS(bake_texture(relief_snapshot(), 256, stop), BuildStopped);
}

// An apartment of 12 views.
const std::filesystem::path& apartment() {
  static const TemporaryFolder folder;
  static const bool made = [] {
    SynthOptions options;
    options.views = 12;
    options.width = 64;
    options.height = 48;
    options.samples = 1;
    options.triangles = 3000;
    write_synthetic_scene(options, folder.path());
    return true;
  }();
  REQUIRE(made);
  return folder.path();
}

BuildOptions quick_options() {
  BuildOptions options;
  options.refine = RefineMode::none;
  return options;
}

TEST_CASE("a build saves a base texture of a bounded size, tells its bytes, and shows the same with and without") {
  BuildOptions options = quick_options();
  const TemporaryFolder folder;
  const BuildResult with = build_model(apartment(), options);
  REQUIRE(with.texture);
  const nlohmann::json totals = save_model(with, folder / "with.glb");
  CHECK(totals["texture"]["side"] == with.texture->texture.image.width);
  CHECK(totals["texture"]["side"] <= 2048);
  CHECK(totals["texture"]["charts"] > 0);
  options.texture_px.reset();
  const BuildResult without = build_model(apartment(), options);
  CHECK_FALSE(without.texture);
  CHECK(save_model(without, folder / "without.glb")["texture"].is_null());
  CHECK(with.gpu_bytes.sum() == without.gpu_bytes.sum());
  const nlohmann::json facts = inspect_model(folder / "with.glb"), plain = inspect_model(folder / "without.glb");
  CHECK(facts["gpu"] == plain["gpu"]);
  CHECK(facts["mesh"] == plain["mesh"]);
  CHECK(plain["file"]["texture"] == 0);
  const auto texture_bytes = encode_image(with.texture->texture.image, with.texture->texture.coding).size();
  CHECK(facts["file"]["texture"] == texture_bytes);
  const auto on_disk = std::filesystem::file_size(folder / "with.glb");
  CHECK(facts["file"]["sum"] <= on_disk);
  CHECK(facts["file"]["sum"].get<std::uint64_t>() + 1000 > on_disk);  // headers, and padding to four bytes
  const Snapshot a = read_model(folder / "with.glb").snapshot, b = read_model(folder / "without.glb").snapshot;
  CHECK(a.surface->mesh.positions == b.surface->mesh.positions);
  CHECK(a.surface->mesh.faces == b.surface->mesh.faces);
  CHECK(a.vertex_colors == b.vertex_colors);
  CHECK(a.references.views == b.references.views);
}

TEST_CASE("a model whose charts do not fit into its base texture has vertex colours, and a warning says so") {
  BuildOptions options = quick_options();
  options.texture_px = kLeastTexturePx;
  const BuildResult result = build_model(apartment(), options);
  CHECK_FALSE(result.texture);
  REQUIRE_FALSE(result.warnings.empty());
  CHECK_THAT(result.warnings.back(), Catch::StartsWith("other programs show averaged colours instead of a texture: ") &&
                                         Catch::Contains("--texture"));
  options.texture_px = kLeastTexturePx - 1;
  CHECK_THROWS_WITH(build_model(apartment(), options), "build: texture_px is 63, must be in [64, 16384]");
}

}  // namespace
}  // namespace lumatlas
