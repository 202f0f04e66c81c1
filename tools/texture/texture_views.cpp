// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/texture_views.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>

#include "atlas/images/srgb.h"
#include "mesh/base/median.h"
#include "tools/texture/layout/edge_distance.h"

namespace lumatlas {

namespace {

using glm::vec2;
using glm::vec3;

// A view sees what lies at most this share behind its stored depth, as blend/ has it.
constexpr float kOcclusionTolerance = 0.02f;
constexpr std::uint32_t kMostLevels = 4;

// The level whose shorter side has about a hundred texels.
std::uint32_t smooth_level(const Camera& camera) {
  const double side = std::min(camera.width, camera.height);
  return static_cast<std::uint32_t>(std::clamp(std::lround(std::log2(side / 120.0)), 1l, 6l));
}

// The validity of what is in the model, by pixel.
std::vector<std::uint8_t> resident_mask(const Snapshot& snapshot, ViewSlot slot) {
  const StoredView& view = *snapshot.views[slot];
  std::vector<std::uint8_t> mask = view.mask->validity.all();
  if (!snapshot.tiles.whole_views()) {
    const std::vector<std::uint8_t> resident = snapshot.tiles.resident_pixels(slot, view.camera);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = resident[i] ? mask[i] : 0;
  }
  return mask;
}

// Returns 0 to 255 for each pixel: see TextureView.
std::vector<std::uint8_t> faded(std::vector<std::uint8_t> mask, const StoredView& view, std::uint32_t fade_px) {
  std::vector<std::uint8_t> good(mask.size());
  for (std::size_t i = 0; i < mask.size(); ++i) good[i] = mask[i] >= 128 && !view.mask->at_rim(i);
  const std::vector<float> distance = edge_distances(good, view.camera.width, view.camera.height);
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask[i] == 0) continue;
    const float t = std::min(1.0f, distance[i] / static_cast<float>(fade_px));
    const float share = t * t * (3 - 2 * t);
    mask[i] = static_cast<std::uint8_t>(std::max(1.0f, std::round(share * mask[i])));
  }
  return mask;
}

// The four texels around a position and their shares, with those beyond the border repeated.
struct Bilinear {
  std::size_t at[4];
  float share[4];
};

Bilinear bilinear(const vec2& position, std::uint32_t width, std::uint32_t height) {
  const float x = std::clamp(position.x - 0.5f, 0.0f, static_cast<float>(width - 1));
  const float y = std::clamp(position.y - 0.5f, 0.0f, static_cast<float>(height - 1));
  const auto x0 = static_cast<std::size_t>(x), y0 = static_cast<std::size_t>(y);
  const std::size_t x1 = std::min<std::size_t>(x0 + 1, width - 1), y1 = std::min<std::size_t>(y0 + 1, height - 1);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  return {{y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1},
          {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

ViewColor sampled(const ImageLevel& level, const vec2& position) {
  const auto& linear = linear_from_srgb8();
  const Bilinear texels = bilinear(position, level.width, level.height);
  ViewColor sample;
  for (int i = 0; i < 4; ++i) {
    const std::uint8_t* rgba = &level.rgba[4 * texels.at[i]];
    sample.color += texels.share[i] * vec3(linear[rgba[0]], linear[rgba[1]], linear[rgba[2]]);
    sample.trust += texels.share[i] * static_cast<float>(rgba[3]) / 255.0f;
  }
  return sample;
}

}  // namespace

TextureView::TextureView(const Snapshot& snapshot, ViewSlot slot)
    : TextureView(*snapshot.views[slot], snapshot.gains[slot], resident_mask(snapshot, slot)) {}

TextureView::TextureView(const StoredView& view, const glm::dvec3& gain)
    : TextureView(view, gain, view.mask->validity.all()) {}

TextureView::TextureView(const StoredView& view, const glm::dvec3& gain, std::vector<std::uint8_t> mask)
    : view_(view), gain_(gain), center_(view.camera.center()) {
  const Camera& camera = view_.camera;
  const glm::dmat3& rotation = camera.cam_from_world_rotation;
  for (int row = 0; row < 3; ++row) rows_[row] = vec3(rotation[0][row], rotation[1][row], rotation[2][row]);
  translation_ = vec3(camera.cam_from_world_translation);
  focal_ = vec2(camera.fx, camera.fy);
  principal_ = vec2(camera.cx, camera.cy);
  size_ = vec2(camera.width, camera.height);
  focal_px_ = static_cast<float>(std::sqrt(camera.fx * camera.fy));
  const std::uint32_t smooth = smooth_level(camera);
  const std::uint32_t levels = std::max(kMostLevels, smooth + 1), unit = 1u << (levels - 1);
  const auto faded_mask = std::make_shared<ViewMask>();
  faded_mask->validity = faded(std::move(mask), view_, 3u << smooth);
  const StoredView blended{view_.name, camera, view_.photograph, faded_mask};
  const auto whole = [&](std::uint32_t side) { return (side + unit - 1) / unit * unit; };
  levels_ = image_levels(blended, {0, 0, whole(camera.width), whole(camera.height)}, levels);
  smooth_unit_ = 1u << smooth;
  find_smooth();
}

// A level's colours, averaged by (1 4 6 4 1) / 16 and by their trust along rows and columns, so that what may not be
// used does not bleed in.
void TextureView::find_smooth() {
  const auto& linear = linear_from_srgb8();
  std::uint32_t level_number = 0;
  while ((1u << level_number) < smooth_unit_) ++level_number;
  const ImageLevel& level = levels_[level_number];
  smooth_width_ = level.width;
  smooth_height_ = level.height;
  std::vector<glm::vec4> values(std::size_t{level.width} * level.height), across(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint8_t* rgba = &level.rgba[4 * i];
    const float trust = std::max(static_cast<float>(rgba[3]) / 255.0f, 1e-5f);
    values[i] = glm::vec4(trust * gain_ * vec3(linear[rgba[0]], linear[rgba[1]], linear[rgba[2]]), trust);
  }
  constexpr float kShares[5] = {1 / 16.0f, 4 / 16.0f, 6 / 16.0f, 4 / 16.0f, 1 / 16.0f};
  const auto filter = [&](const std::vector<glm::vec4>& from, std::vector<glm::vec4>& to, bool along_x) {
    const auto width = static_cast<std::int64_t>(level.width), height = static_cast<std::int64_t>(level.height);
    for (std::int64_t y = 0; y < height; ++y) {
      for (std::int64_t x = 0; x < width; ++x) {
        glm::vec4 sum(0);
        for (std::int64_t k = -2; k <= 2; ++k) {
          const std::int64_t sx = along_x ? std::clamp<std::int64_t>(x + k, 0, width - 1) : x;
          const std::int64_t sy = along_x ? y : std::clamp<std::int64_t>(y + k, 0, height - 1);
          sum += kShares[k + 2] * from[static_cast<std::size_t>(sy * width + sx)];
        }
        to[static_cast<std::size_t>(y * width + x)] = sum;
      }
    }
  };
  filter(values, across, true);
  filter(across, values, false);
  smooth_.resize(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) smooth_[i] = vec3(values[i]) / values[i].w;
}

bool TextureView::locate(const vec3& point, ImagePoint& place) const {
  const float z = glm::dot(rows_[2], point) + translation_.z;
  if (!(z > 0)) return false;
  const vec2 across(glm::dot(rows_[0], point) + translation_.x, glm::dot(rows_[1], point) + translation_.y);
  place = {across / z * focal_ + principal_, z};
  return place.image.x >= 0 && place.image.y >= 0 && place.image.x < size_.x && place.image.y < size_.y;
}

void TextureView::prefetch(const ImagePoint& place) const {
  view_.mask->depth.prefetch(pixel_at(place.image, view_.camera.width));
  __builtin_prefetch(&levels_[0].rgba[4 * pixel_at(place.image, levels_[0].width)]);
}

bool TextureView::shows(const ImagePoint& place) const {
  if (place.depth > view_.mask->depth[pixel_at(place.image, view_.camera.width)] * (1 + kOcclusionTolerance))
    return false;
  return levels_[0].rgba[4 * pixel_at(place.image, levels_[0].width) + 3] != 0;
}

ViewColor TextureView::sharp(const vec2& image, float footprint) const {
  const float level = std::clamp(std::log2(std::max(footprint, 1.0f)), 0.0f, static_cast<float>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const float share = level - static_cast<float>(fine);
  const auto at_level = [&](std::size_t number) {
    return sampled(levels_[number], image / static_cast<float>(1u << number));
  };
  ViewColor sample = at_level(fine);
  if (share > 0) {
    const ViewColor coarse = at_level(fine + 1);
    sample.color += share * (coarse.color - sample.color);
    sample.trust += share * (coarse.trust - sample.trust);
  }
  sample.color *= gain_;
  return sample;
}

vec3 TextureView::log_exposure() const {
  return -glm::log(gain_);
}

vec3 TextureView::smooth(const vec2& image) const {
  const Bilinear texels = bilinear(image / static_cast<float>(smooth_unit_), smooth_width_, smooth_height_);
  vec3 sum(0);
  for (int i = 0; i < 4; ++i) sum += texels.share[i] * smooth_[texels.at[i]];
  return sum;
}

std::vector<float> densities_in(const TextureView& view, const Surface& surface) {
  const std::vector<vec3>& positions = surface.mesh.positions;
  std::vector<float> of_vertex(positions.size(), 0);
  for_each_seen(view, positions, [&](std::size_t v, const TextureView::ImagePoint& place) {
    of_vertex[v] = view.focal_px() / place.depth;
  });
  TextureView::ImagePoint place;
  std::vector<float> of_cell(surface.cells.cells.size(), 0);
  for (std::size_t face = 0; face < surface.mesh.faces.size(); ++face) {
    const glm::uvec3& f = surface.mesh.faces[face];
    float& cell = of_cell[surface.cells.cell_of_face[face]];
    cell = std::max({cell, of_vertex[f.x], of_vertex[f.y], of_vertex[f.z]});
    if (cell > 0) continue;
    const vec3 middle = (positions[f.x] + positions[f.y] + positions[f.z]) / 3.0f;
    if (view.sees(middle, place)) cell = view.focal_px() / place.depth;
  }
  return of_cell;
}

TextureViews texture_views(const Snapshot& snapshot) {
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) slots.push_back(slot);
  }
  std::vector<std::optional<TextureView>> made(slots.size());
  std::vector<std::vector<float>> densities(slots.size());
  tbb::parallel_for(std::size_t{0}, slots.size(), [&](std::size_t i) {
    made[i].emplace(snapshot, slots[i]);
    densities[i] = densities_in(*made[i], *snapshot.surface);
  });
  TextureViews result;
  for (auto& view : made) result.views.push_back(std::move(*view));
  result.first_seen.push_back(0);
  std::vector<double> of_cell;
  for (std::size_t cell = 0; cell < snapshot.surface->cells.cells.size(); ++cell) {
    of_cell.clear();
    for (std::uint32_t i = 0; i < slots.size(); ++i) {
      if (!(densities[i][cell] > 0)) continue;
      result.seen_by.push_back(i);
      of_cell.push_back(densities[i][cell]);
    }
    result.first_seen.push_back(static_cast<std::uint32_t>(result.seen_by.size()));
    result.density.push_back(of_cell.empty() ? 0 : median(of_cell));
  }
  return result;
}

}  // namespace lumatlas
