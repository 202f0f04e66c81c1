// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/tiles.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <stdexcept>

#include "blend/gl/gl_objects.h"
#include "blend/gl/picture_parts.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

// Copies a tile's values to their places in the whole image, from what was drawn of a larger tile that holds it.
template <typename T>
void paste(const std::vector<T>& part, const Tile& drawn, const Tile& tile, std::size_t values_per_pixel,
           std::uint32_t whole_width, std::vector<T>& whole) {
  const std::size_t row = values_per_pixel * tile.camera.width;
  for (std::size_t y = tile.top; y < std::size_t{tile.top} + tile.camera.height; ++y) {
    const std::size_t from = (y - drawn.top) * drawn.camera.width + (tile.left - drawn.left);
    const std::size_t to = y * whole_width + tile.left;
    std::copy_n(&part[values_per_pixel * from], row, &whole[values_per_pixel * to]);
  }
}

// With the pixels around it in the image that its own depend on.
Tile with_neighbours(const Tile& tile, const Camera& whole) {
  Tile larger{tile.left - std::min(tile.left, kAroundPart), tile.top - std::min(tile.top, kAroundPart), whole};
  larger.camera.width = std::min(tile.left + tile.camera.width + kAroundPart, whole.width) - larger.left;
  larger.camera.height = std::min(tile.top + tile.camera.height + kAroundPart, whole.height) - larger.top;
  larger.camera.cx -= larger.left;
  larger.camera.cy -= larger.top;
  return larger;
}

// Returns tiles that the driver takes with the pixels around them.
std::vector<Tile> drawable_tiles(const Camera& camera, std::uint32_t side) {
  const auto most = static_cast<std::uint32_t>(gl_limit(GL_MAX_TEXTURE_SIZE));
  return tiles_of(camera, std::min(side, most - 2 * kAroundPart));
}

}  // namespace

void check_picture_size(const Camera& camera) {
  if (std::uint64_t{camera.width} * camera.height <= kMostPicturePixels) return;
  throw std::invalid_argument("picture: " + size_text(camera.width, camera.height) +
                              " is more than 2^30 pixels, name a smaller picture");
}

std::vector<Tile> tiles_of(const Camera& camera, std::uint32_t side) {
  check(camera);
  check_picture_size(camera);
  if (side < 1) throw std::invalid_argument("tiles: side is 0, must be at least 1");
  std::vector<Tile> tiles;
  for (std::uint32_t top = 0; top < camera.height; top += std::min(side, camera.height - top)) {
    for (std::uint32_t left = 0; left < camera.width; left += std::min(side, camera.width - left)) {
      Tile tile{left, top, camera};
      tile.camera.width = std::min(side, camera.width - left);
      tile.camera.height = std::min(side, camera.height - top);
      tile.camera.cx -= left;
      tile.camera.cy -= top;
      tiles.push_back(tile);
    }
  }
  return tiles;
}

Rendering render_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options, std::uint32_t side) {
  check(options);
  const std::vector<Tile> tiles = drawable_tiles(camera, side);
  if (tiles.size() == 1) return renderer.render(camera, options);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  Rendering whole;
  whole.picture.width = camera.width;
  whole.picture.height = camera.height;
  whole.picture.rgb.resize(3 * pixels);
  whole.state.resize(pixels);
  for (const Tile& tile : tiles) {
    const Tile drawn = with_neighbours(tile, camera);
    const Rendering part = renderer.render(drawn.camera, options);
    paste(part.picture.rgb, drawn, tile, 3, camera.width, whole.picture.rgb);
    paste(part.state, drawn, tile, 1, camera.width, whole.state);
  }
  return whole;
}

LinearRendering render_linear_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options,
                                    std::uint32_t side) {
  check(options);
  const std::vector<Tile> tiles = drawable_tiles(camera, side);
  if (tiles.size() == 1) return renderer.render_linear(camera, options);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  LinearRendering whole{camera.width, camera.height, std::vector<float>(3 * pixels), std::vector<PixelState>(pixels)};
  for (const Tile& tile : tiles) {
    const Tile drawn = with_neighbours(tile, camera);
    const LinearRendering part = renderer.render_linear(drawn.camera, options);
    paste(part.rgb, drawn, tile, 3, camera.width, whole.rgb);
    paste(part.state, drawn, tile, 1, camera.width, whole.state);
  }
  return whole;
}

Diagnosis diagnose_tiled(Renderer& renderer, const Camera& camera, const BlendOptions& options, std::uint32_t side) {
  check(options);
  const std::vector<Tile> tiles = drawable_tiles(camera, side);
  if (tiles.size() == 1) return renderer.diagnose(camera, options);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  Diagnosis whole{camera.width, camera.height, std::vector<PixelState>(pixels), std::vector<PixelDiagnosis>(pixels)};
  for (const Tile& tile : tiles) {
    const Diagnosis part = renderer.diagnose(tile.camera, options);
    paste(part.state, tile, tile, 1, camera.width, whole.state);
    paste(part.pixels, tile, tile, 1, camera.width, whole.pixels);
  }
  return whole;
}

}  // namespace lumatlas
