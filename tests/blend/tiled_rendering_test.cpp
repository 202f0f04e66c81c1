// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs in tiles give the picture of whole photographs, without seams; coarser levels keep far pictures calm.
#include <epoxy/gl.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "atlas/images/srgb.h"
#include "blend/gl/photograph_array.h"
#include "blend/gpu_bytes.h"
#include "blend/reference.h"
#include "blend/renderer.h"
#include "blend/sampling/cubic_kernel.h"
#include "planner/tile_choice.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/rendering_difference.h"
#include "tests/support/scenes/small_scenes.h"
#include "tests/support/scenes/view_parts.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

Camera between_views(std::size_t number) {
  Camera camera = room_camera(number).scaled_to(240, 180);
  const Camera next = room_camera(number + 1);
  camera.cam_from_world_translation = -(camera.cam_from_world_rotation * ((camera.center() + next.center()) / 2.0));
  return camera;
}

TEST_CASE("tiles of any size show what whole photographs show") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const std::uint32_t gutter : {1u, 2u, 4u, 8u}) {
    BlendOptions options;
    if (gutter == 1) options.sampling = BlendOptions::Sampling::linear;  // such tiles have no room for cubic
    Renderer whole;
    whole.load(room_snapshot(10, {}, {0, gutter, 0}));
    for (const std::uint32_t side : {8u, 32u, 128u}) {
      Renderer tiles;
      tiles.load(room_snapshot(10, {}, {side, gutter, 0}));
      for (std::size_t number = 0; number < 3; ++number) {
        INFO("tiles of " << side << " pixels with a gutter of " << gutter);
        const Camera camera = between_views(3 * number);
        // A point within the occlusion tolerance behind another cell may be in a tile that no reference to that one
        // needs.
        CHECK(share_different(tiles.render(camera, options), whole.render(camera, options), 1) <= 0.0001);
      }
    }
  }
}

TEST_CASE("the shader agrees with the CPU reference where only some tiles are resident") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot all = room_snapshot(12, {}, {16, 2, 0});
  const std::uint32_t most = all.tiles.resident_tiles() / 3;
  const Snapshot some = room_snapshot(12, {}, {16, 2, most}, choose_tiles);
  REQUIRE(some.tiles.resident_tiles() == most);
  const auto visibility = make_ray_visibility(some.surface->mesh);
  Renderer renderer;
  renderer.load(some);
  CHECK(array_bytes(some) >= most * place_bytes({16, 2, 0}));
  double different = 0, changed = 0;
  for (std::size_t number = 0; number < 4; ++number) {
    const Camera camera = between_views(2 * number);
    const Rendering cpu = render_reference(some, camera, *visibility, {});
    different += share_different(renderer.render(camera, {}), cpu, 2) / 4;
    changed += share_different(render_reference(all, camera, *visibility, {}), cpu, 2) / 4;
  }
  CHECK(different <= 0.001);
  CHECK(changed > 0.01);  // it is not the same picture
}

TEST_CASE("the shader agrees with the CPU reference on compressed texels, for any number of threads") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot plain = room_snapshot(12, {}, {16, 4, 0});
  for (const std::uint32_t tile : {0u, 16u}) {
    const Snapshot packed = room_snapshot(12, {}, {tile, 4, 0, TexelFormat::bc7});
    const auto visibility = make_ray_visibility(packed.surface->mesh);
    Renderer renderer({.blocks = true}), decompressing({.blocks = false});
    renderer.load(packed);
    decompressing.load(packed);
    double different = 0, of_decompressed = 0, changed = 0;
    for (std::size_t number = 0; number < 4; ++number) {
      const Camera camera = between_views(2 * number);
      const Rendering cpu = render_reference(packed, camera, *visibility, {});
      different += share_different(renderer.render(camera, {}), cpu, 2) / 4;
      of_decompressed += share_different(decompressing.render(camera, {}), cpu, 2) / 4;
      changed += share_different(render_reference(plain, camera, *visibility, {}), cpu, 2) / 4;
    }
    INFO("tiles of " << tile);
    CHECK(different <= 0.001);
    CHECK(of_decompressed <= 0.001);
    CHECK(changed > 0.01);  // compression is seen by both
    const tbb::global_control single(tbb::global_control::max_allowed_parallelism, 1);
    Renderer alone({.blocks = true});
    alone.load(packed);
    CHECK(alone.render(between_views(3), {}).picture.rgb == renderer.render(between_views(3), {}).picture.rgb);
  }
}

// All bytes of the buffers and textures that the current context has, by what it says itself; pictures of that width
// are left out, and the raw texels that share the memory of photographs.
std::uint64_t bytes_in_context(GLsizei picture_width) {
  constexpr GLuint kMostNames = 200;
  std::uint64_t bytes = 0;
  for (GLuint name = 1; name < kMostNames; ++name) {
    if (glIsBuffer(name) != GL_FALSE) {
      GLint64 size = 0;
      glGetNamedBufferParameteri64v(name, GL_BUFFER_SIZE, &size);
      bytes += static_cast<std::uint64_t>(size);
    }
    if (glIsTexture(name) == GL_FALSE) continue;
    for (GLint level = 0;; ++level) {
      const auto of_level = [&](GLenum what) {
        GLint value = 0;
        glGetTextureLevelParameteriv(name, level, what, &value);
        return value;
      };
      const GLint width = of_level(GL_TEXTURE_WIDTH);
      if (width == 0 || (level == 0 && width % picture_width == 0)) break;
      if (of_level(GL_TEXTURE_INTERNAL_FORMAT) == GL_RGBA8) break;
      if (of_level(GL_TEXTURE_COMPRESSED) != 0) {
        bytes += static_cast<std::uint64_t>(of_level(GL_TEXTURE_COMPRESSED_IMAGE_SIZE));
        continue;
      }
      GLint bits = 0;
      for (const GLenum part :
           {GL_TEXTURE_RED_SIZE, GL_TEXTURE_GREEN_SIZE, GL_TEXTURE_BLUE_SIZE, GL_TEXTURE_ALPHA_SIZE})
        bits += of_level(part);
      bytes += static_cast<std::uint64_t>(bits / 8) * static_cast<std::uint64_t>(width) *
               static_cast<std::uint64_t>(of_level(GL_TEXTURE_HEIGHT)) *
               static_cast<std::uint64_t>(of_level(GL_TEXTURE_DEPTH));
    }
  }
  return bytes;
}

TEST_CASE("texels stay in blocks, or are decompressed as they are loaded: by default if software draws") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Snapshot packed = room_snapshot(3, {}, {16, 4, 0, TexelFormat::bc7});
  const std::uint64_t in_blocks = array_shape(packed, true).bytes(), decompressed = array_shape(packed, false).bytes();
  CHECK(decompressed > 2 * in_blocks);
  PhotographArray array;
  array.load(packed, false);
  CHECK(array.shape().format == TexelFormat::rgb8);
  array.load(packed, true);
  CHECK(array.shape().format == TexelFormat::bc7);
  CHECK(array.uploaded_slots() == packed.tiles.resident_tiles());
  const std::uint64_t before = bytes_in_context(37);
  Renderer renderer;
  renderer.load(packed);
  const std::uint64_t taken = bytes_in_context(37) - before;
  CHECK((taken > decompressed) == draws_in_software());
}

TEST_CASE("an array takes no more than its budget") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const std::uint64_t budget : {20'000ull, 150'000ull, 1'000'000ull, 9'000'000ull}) {
    TileOptions layout{16, 2, 0};
    layout.max_tiles = places_within(budget, layout);
    const Snapshot snapshot = room_snapshot(8, {}, layout, choose_tiles);
    CHECK(array_bytes(snapshot) <= budget);
    CHECK(array_bytes(snapshot) > budget * 3 / 4);
  }
}

TEST_CASE("what a model takes on the GPU is counted to the byte, whole views and tiles, with cells joined or not") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const TileOptions layout :
       {TileOptions{16, 2, 0}, TileOptions{64, 8, 0}, TileOptions{0, 4, 0}, TileOptions{16, 4, 0, TexelFormat::bc7},
        TileOptions{64, 8, 0, TexelFormat::bc7}, TileOptions{0, 4, 0, TexelFormat::bc7}}) {
    if (!driver_takes(layout.texels)) continue;
    for (const double width : {0.0, 0.1}) {
      INFO("tiles of " << layout.tile_px << " pixels, borders of " << width);
      const Snapshot snapshot = room_snapshot(7, {}, layout);
      Renderer renderer({.blocks = true});
      const std::uint64_t before = bytes_in_context(37);
      renderer.load(snapshot);
      BlendOptions options;
      options.border_width = width;
      (void)renderer.render(room_camera(1).scaled_to(37, 29), options);
      const GpuBytes counted = GpuByteCount(snapshot.surface, width).of(snapshot);
      CHECK(bytes_in_context(37) - before == counted.sum());
      CHECK(array_bytes(snapshot) == counted.photographs());
      CHECK(GpuByteCount(snapshot.surface, width).of_surface() <= counted.mesh + counted.vertices + counted.tables);
    }
  }
}

TEST_CASE("what stays resident is not copied again") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto atlas = room_atlas(9, {}, {16, 2, 0});
  PhotographArray array;
  const Snapshot first = atlas->snapshot();
  array.load(first);
  CHECK(array.uploaded_slots() == first.tiles.resident_tiles());
  array.load(atlas->snapshot());
  CHECK(array.uploaded_slots() == 0);
  // Another photograph in the place of one view: those of its tiles are copied that show something else, and no others.
  StoredView changed = *atlas->view(4);
  change_photograph(changed, [](Photograph& photograph) { photograph.rgb[0] ^= 1; });
  const VisibilityBuffer visible = make_ray_visibility(atlas->surface()->mesh)->trace(changed.camera);
  std::vector<ShownCell> shown = shown_cells(changed, visible.face, atlas->surface()->cells, atlas->layout());
  atlas->replace(4, std::move(changed), std::move(shown));
  const Snapshot second = atlas->snapshot();
  array.load(second);
  REQUIRE(second.tiles.places[second.tiles.first_tile[4]] != TilePlace::none);
  CHECK(array.uploaded_slots() == 1);
}

// The first views of a snapshot in tiles.
Snapshot first_views(Snapshot snapshot, std::size_t count) {
  const auto tiles = snapshot.tiles.places.begin();
  std::fill(tiles + snapshot.tiles.first_tile[count], snapshot.tiles.places.end(), TilePlace::none);
  leave_out_views_without_tiles(snapshot);
  return snapshot;
}

TEST_CASE("a store that grows view by view is copied once: an array that is too small hands over what it holds") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  for (const TileOptions layout : {TileOptions{16, 2, 0}, TileOptions{16, 4, 0, TexelFormat::bc7}}) {
    if (!driver_takes(layout.texels)) continue;
    const Snapshot all = room_snapshot(9, {}, layout);
    PhotographArray array;
    Renderer renderer({.blocks = true});
    std::uint32_t before = 0, pages = 0, grown = 0;
    for (std::size_t views = 3; views <= 9; ++views) {
      CAPTURE(views);
      const Snapshot snapshot = first_views(all, views);
      array.load(snapshot);
      const std::uint32_t resident = snapshot.tiles.resident_tiles();
      CHECK(array.uploaded_slots() == resident - before);
      before = resident;
      grown += array.shape().pages > pages;
      pages = array.shape().pages;
      renderer.load(snapshot);
      Renderer fresh({.join_cells = false, .blocks = true});
      fresh.load(snapshot);
      const Rendering made = fresh.render(room_camera(views), {});
      CHECK(share_different(renderer.render(room_camera(views), {}), made, views == 3 ? 1 : 0) == 0);
    }
    CHECK(grown >= 3);                // the first time from nothing
    CHECK(grown < 7);                 // not with every view
    array.load(first_views(all, 2));  // most of it would be of no use
    CHECK(array.shape().pages < pages);
    CHECK(array.uploaded_slots() == first_views(all, 2).tiles.resident_tiles());
  }
}

// One view straight at a wall, everywhere in one cell, with a photograph of the caller's.
template <typename Grey>
Snapshot wall_with(const Camera& camera, const TileOptions& layout, const Grey& grey) {
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 4, 4, 4, 4);
  surface->cells = measure_cells(surface->mesh, std::vector<CellId>(surface->mesh.faces.size(), 0), 10);
  Photograph photograph{camera.width, camera.height, {}, {}};
  for (std::uint32_t y = 0; y < camera.height; ++y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      photograph.rgb.insert(photograph.rgb.end(), 3, static_cast<std::uint8_t>(grey(x, y)));
    }
  }
  Atlas atlas(surface, 1, layout);
  TiledView tiled = make_tiled_view("wall", camera, std::move(photograph),
                                    make_ray_visibility(surface->mesh)->trace(camera), surface->cells, layout, {});
  atlas.insert(std::move(tiled.view), std::move(tiled.shown));
  atlas.set_references(0, {0});
  return atlas.snapshot();
}

TEST_CASE("a gradient goes on over the borders of tiles") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Camera stored = forward_camera(128, 128);
  for (const double away : {0.0, 1.5, 6.0}) {  // nearer footprints, and such of two and four pixels
    const Snapshot snapshot =
        wall_with(stored, {16, 4, 0}, [](std::uint32_t x, std::uint32_t y) { return 20 + x + y / 2; });
    Renderer renderer;
    renderer.load(snapshot);
    Camera camera = forward_camera(128, 128, {0, 0, -away});
    const Rendering picture = renderer.render(camera, {});
    for (std::uint32_t y = 50; y < 78; ++y) {
      for (std::uint32_t x = 50; x < 77; ++x) {
        const int step = picture.picture.rgb[3 * (128 * y + x + 1)] - picture.picture.rgb[3 * (128 * y + x)];
        const double expected = (4 + away) / 4;  // levels from pixel to pixel
        INFO("pixel " << x << ", " << y << ", camera back by " << away);
        REQUIRE(std::abs(step - expected) <= 1.5);
      }
    }
  }
}

TEST_CASE("a photograph taken from nearer is averaged, not sampled here and there") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Camera stored = forward_camera(256, 256);
  const Snapshot snapshot =
      wall_with(stored, {64, 4, 0}, [](std::uint32_t x, std::uint32_t y) { return (x ^ y) & 1 ? 255 : 0; });
  Renderer renderer;
  renderer.load(snapshot);
  Camera camera = forward_camera(256, 256, {0.013, 0.007, -12});  // four times as far
  const auto error = [&](bool prefilter) {
    BlendOptions options;
    options.prefilter = prefilter;
    const Rendering picture = renderer.render(camera, options);
    double sum = 0;
    int pixels = 0;
    for (std::uint32_t y = 112; y < 144; ++y) {
      for (std::uint32_t x = 112; x < 144; ++x, ++pixels) {
        REQUIRE(picture.state[256 * y + x] == PixelState::textured);
        sum += std::abs(linear_from_srgb8()[picture.picture.rgb[3 * (256 * y + x)]] - 0.5f);
      }
    }
    return sum / pixels;
  };
  CHECK(error(true) < 0.01);
  CHECK(error(false) > 0.05);
}

// The mean difference between neighbours in a row of the picture's middle, levels.
double contrast(const Rendering& picture) {
  const std::uint32_t width = picture.picture.width;
  double sum = 0;
  int pixels = 0;
  for (std::uint32_t y = 112; y < 144; ++y) {
    for (std::uint32_t x = 112; x < 144; ++x, ++pixels) {
      const std::size_t at = std::size_t{y} * width + x;
      REQUIRE(picture.state[at] == PixelState::textured);
      sum += std::abs(picture.picture.rgb[3 * at + 3] - picture.picture.rgb[3 * at]);
    }
  }
  return sum / pixels;
}

TEST_CASE("a surface that is off blurs pictures from beside a photograph, and none from where it was taken") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const Camera stored = forward_camera(256, 256);
  Snapshot exact = wall_with(stored, {64, 4, 0}, [](std::uint32_t x, std::uint32_t) { return x / 2 % 2 ? 200 : 60; });
  Snapshot off = exact;
  off.cell_deviation.assign(off.cell_seen.size(), 0.1f);
  const auto contrasts = [&](const Snapshot& snapshot, const Camera& camera, const BlendOptions& options) {
    Renderer renderer;
    renderer.load(snapshot);
    return contrast(renderer.render(camera, options));
  };
  CHECK(contrasts(off, stored, {}) == contrasts(exact, stored, {}));
  // 0.1 scene units are 0.3 pixels here, less than what is blurred, and 1.6 pixels there.
  const Camera near = forward_camera(256, 256, {0.2, 0, 0});
  CHECK(contrasts(off, near, {}) == contrasts(exact, near, {}));
  const Camera beside = forward_camera(256, 256, {1, 0, 0});
  CHECK(contrasts(off, beside, {}) < 0.8 * contrasts(exact, beside, {}));
  BlendOptions sharp;
  sharp.soften = false;
  CHECK(contrasts(off, beside, sharp) == contrasts(exact, beside, sharp));
}

TEST_CASE("the cubic kernel is a mean about its place, as wide as the area that a pixel covers") {
  for (const double width : {0.3, 1.0, 1.4, 1.9, 2.2}) {
    for (const double f : {0.0, 0.2, 0.5, 0.9}) {
      const std::array<double, 4> shares = cubic_shares(f, width);
      double sum = 0, first = 0, second = 0;
      for (int i = 0; i < 4; ++i) {
        const double away = i - 1 - f;
        sum += shares[static_cast<std::size_t>(i)];
        first += shares[static_cast<std::size_t>(i)] * away;
        second += shares[static_cast<std::size_t>(i)] * away * away;
      }
      INFO("width " << width << ", place " << f);
      CHECK(sum == Approx(1).margin(1e-12));
      CHECK(first == Approx(0).margin(1e-12));
      CHECK(second == Approx(std::max(0.0, width * width - 1) / 12).margin(1e-12));
    }
  }
}

// Linear light of a picture whose pixels are half way between those of a photograph with stripes of two pixels, 0.5 and
// 0.2: on a stripe, beside one.
std::pair<float, float> between_stripes(std::uint32_t gutter, BlendOptions::Sampling sampling) {
  const Camera stored = forward_camera(128, 128);
  const int bright = srgb8_from_linear(0.5);
  const int dark = srgb8_from_linear(0.2);
  const Snapshot snapshot =
      wall_with(stored, {64, gutter, 0}, [&](std::uint32_t x, std::uint32_t) { return x % 4 < 2 ? bright : dark; });
  Renderer renderer;
  renderer.load(snapshot);
  Camera camera = stored;
  camera.cx -= 0.5;
  BlendOptions options;
  options.sampling = sampling;
  const Rendering picture = renderer.render(camera, options);
  const Rendering cpu = render_reference(snapshot, camera, *make_ray_visibility(snapshot.surface->mesh), options);
  CHECK(share_different(picture, cpu, 1) == 0);
  const auto at = [&](std::size_t x) { return linear_from_srgb8()[picture.picture.rgb[3 * (128 * 64 + x)]]; };
  for (const std::size_t first : {60u, 64u}) {  // on either side of a border of tiles
    CHECK(at(first) == at(56));
    CHECK(at(first + 2) == at(58));
  }
  return {at(56), at(58)};
}

TEST_CASE("cubic sampling keeps fine detail that linear sampling blurs, and needs two pixels of gutter") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  using enum BlendOptions::Sampling;
  // Shares -1/16, 9/16, 9/16, -1/16: stripes of 0.15 about 0.35 become such of 1.25 times that.
  const auto [cubic_on, cubic_beside] = between_stripes(4, cubic);
  CHECK(std::abs(cubic_on - (0.35 + 1.25 * 0.15)) < 0.01);
  CHECK(std::abs(cubic_beside - (0.35 - 1.25 * 0.15)) < 0.01);
  const auto [linear_on, linear_beside] = between_stripes(4, linear);
  CHECK(std::abs(linear_on - 0.5) < 0.01);
  CHECK(std::abs(linear_beside - 0.2) < 0.01);
  CHECK(between_stripes(1, cubic) == between_stripes(1, linear));
}

TEST_CASE("cells beyond what 16 bits count are drawn from their own tiles") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const auto surface = std::make_shared<Surface>();
  add_wall(surface->mesh, 190, 190, 0.02f, 4);
  REQUIRE(surface->mesh.faces.size() > (1u << 16));
  std::vector<CellId> own(surface->mesh.faces.size());
  for (std::uint32_t face = 0; face < own.size(); ++face) own[face] = CellId(face);
  surface->cells = measure_cells(surface->mesh, std::move(own), 0.02);
  const Camera camera = forward_camera(256, 256);
  const auto visibility = make_ray_visibility(surface->mesh);
  const TileOptions layout{8, 1, 0};
  Atlas atlas(surface, 2, layout);
  for (int number = 0; number < 2; ++number) {
    Photograph photograph{256, 256, std::vector<std::uint8_t>(3 * 256 * 256, number == 0 ? 60 : 200), {}};
    TiledView tiled =
        make_tiled_view("wall", camera, std::move(photograph), visibility->trace(camera), surface->cells, layout, {});
    atlas.insert(std::move(tiled.view), std::move(tiled.shown));
  }
  for (CellId cell{0}; cell < surface->cells.cells.size(); ++cell) {
    atlas.set_references(cell, {ViewSlot(cell < (1u << 16) ? 0u : 1u)});
  }
  Renderer renderer;
  renderer.load(atlas.snapshot());
  const Camera novel = forward_camera(256, 256, {0.1, 0.05, 0});
  const Rendering picture = renderer.render(novel, {});
  const VisibilityBuffer visible = visibility->trace(novel);
  std::set<int> values;
  std::size_t wrong = 0, shown = 0;
  for (std::size_t pixel = 0; pixel < picture.state.size(); ++pixel) {
    if (picture.state[pixel] != PixelState::textured) continue;
    ++shown;
    wrong += picture.picture.rgb[3 * pixel] != (visible.face[pixel] < (1u << 16) ? 60 : 200);
    values.insert(picture.picture.rgb[3 * pixel]);
  }
  CHECK(shown > 30'000);
  CHECK(wrong * 100 < shown);  // at edges of faces, which GL and the rays may see differently
  CHECK(values.count(60) == 1);
  CHECK(values.count(200) == 1);
}

}  // namespace
}  // namespace lumatlas
