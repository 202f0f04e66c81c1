// SPDX-License-Identifier: GPL-3.0-or-later
// Source: Erat et al. 2019, section 3.1. Kept plain: shaders/blend.frag is tested against it.
#include "blend/reference.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <stdexcept>
#include <string>

#include "atlas/images/image_levels.h"
#include "atlas/images/srgb.h"
#include "atlas/tiles/compressed_texels.h"
#include "atlas/views/depth_blocks.h"
#include "blend/exposure.h"
#include "blend/geometric_weight.h"
#include "blend/outlines.h"
#include "blend/sampling/cubic_kernel.h"
#include "blend/sampling/footprint.h"
#include "blend/sampling/supersampling.h"
#include "blend/soft_edges.h"
#include "blend/tables/fade_zone_shares.h"
#include "blend/tables/zone_mesh.h"

namespace lumatlas {

namespace {

struct WeightedColor {
  double weight = 0;
  glm::dvec3 color{0.0};
  bool valid = false;  // whatever it weighs
};

// A snapshot, and what the texture array shows of its views; by slot, of free slots nothing.
struct Source {
  const Snapshot& snapshot;
  std::vector<std::vector<ImageLevel>> levels;
  std::vector<std::vector<BlockPixel>> depths;
  double before_far;    // depth_before_far() of the surface
  glm::dvec3 exposure;  // the picture's

  Source(const Snapshot& from, const BlendOptions& options, const glm::dvec3& shown_in);
};

Source::Source(const Snapshot& from, const BlendOptions& options, const glm::dvec3& shown_in)
    : snapshot(from),
      levels(from.views.size()),
      depths(from.views.size()),
      before_far(static_cast<double>(depth_before_far(*from.surface))),
      exposure(shown_in) {
  const std::uint32_t count = options.prefilter ? levels_of(snapshot.tiles.options) : 1;
  tbb::parallel_for(std::size_t{0}, levels.size(), [&](std::size_t slot) {
    if (!snapshot.views[slot]) return;
    levels[slot] = shown_levels(*snapshot.views[slot], snapshot.tiles.options, count);
    depths[slot] = shown_depths(*snapshot.views[slot]);
  });
}

// The colour before its gain and the mask, linear between texel centres; beyond the border its texels are repeated.
struct Sample {
  glm::dvec3 color{0.0};
  double validity = 0;
};
Sample bilinear(const ImageLevel& level, const glm::dvec2& position) {
  const auto& linear = linear_from_srgb8();
  const glm::dvec2 last(level.width - 1.0, level.height - 1.0);
  const glm::dvec2 at = glm::clamp(position - 0.5, glm::dvec2(0), last);
  const glm::dvec2 base = glm::floor(at);
  const glm::dvec2 f = at - base;
  Sample sample;
  for (const glm::dvec2& corner : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(0, 1), glm::dvec2(1, 1)}) {
    const auto x = static_cast<std::size_t>(std::min(base.x + corner.x, last.x));
    const auto y = static_cast<std::size_t>(std::min(base.y + corner.y, last.y));
    const double weight = (corner.x > 0 ? f.x : 1 - f.x) * (corner.y > 0 ? f.y : 1 - f.y);
    const std::uint8_t* rgba = &level.rgba[4 * (y * level.width + x)];
    sample.color += weight * glm::dvec3(linear[rgba[0]], linear[rgba[1]], linear[rgba[2]]);
    sample.validity += weight * rgba[3] / 255.0;
  }
  return sample;
}

// Before its gain; beyond the border its texels are repeated.
glm::dvec3 cubic_color(const ImageLevel& level, const glm::dvec2& position, double width) {
  const auto& linear = linear_from_srgb8();
  const glm::dvec2 base = glm::floor(position - 0.5);
  const std::array<double, 4> across = cubic_shares(position.x - 0.5 - base.x, width);
  const std::array<double, 4> down = cubic_shares(position.y - 0.5 - base.y, width);
  glm::dvec3 sum(0);
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      const double x = std::clamp(base.x - 1 + static_cast<double>(column), 0.0, level.width - 1.0);
      const double y = std::clamp(base.y - 1 + static_cast<double>(row), 0.0, level.height - 1.0);
      const std::uint8_t* rgba =
          &level.rgba[4 * (static_cast<std::size_t>(y) * level.width + static_cast<std::size_t>(x))];
      sum += down[row] * across[column] * glm::dvec3(linear[rgba[0]], linear[rgba[1]], linear[rgba[2]]);
    }
  }
  return glm::max(sum, 0.0);  // beside bright detail it may fall below
}

// `position` is in pixels of the finest level; `cubic`: how many levels are sampled so.
glm::dvec3 color_of_level(const std::vector<ImageLevel>& levels, const glm::dvec2& position, double footprint,
                          std::size_t level, std::size_t cubic) {
  const double unit = std::exp2(static_cast<double>(level));
  const glm::dvec2 here = position / unit;
  return level < cubic ? cubic_color(levels[level], here, footprint / unit) : bilinear(levels[level], here).color;
}

// Between the two levels whose texels are next to the footprint: how many pixels one of the picture's covers.
glm::dvec3 filtered(const std::vector<ImageLevel>& levels, const glm::dvec2& image, double footprint,
                    std::size_t cubic) {
  const double level =
      std::clamp(std::log2(std::max(footprint / kSharpFootprint, 1.0)), 0.0, static_cast<double>(levels.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const double share = level - std::floor(level);
  const glm::dvec3 color = color_of_level(levels, image, footprint, fine, cubic);
  return share > 0 ? glm::mix(color, color_of_level(levels, image, footprint, fine + 1, cubic), share) : color;
}

struct SurfacePoint {
  glm::dvec3 world{0.0};
  double z = 0;               // its depth in the novel camera
  double deviation = 0;       // the surface's, see Snapshot::cell_deviation
  bool is_continued = false;  // past its outline, see outlines.h
};

// The share of a view that is left at a point, see BlendOptions; `cam` and `image`: the point in that view.
double share_left(const Source& source, ViewSlot slot, const SurfacePoint& point, const glm::dvec3& cam,
                  const glm::dvec2& image, const Camera& novel, const BlendOptions& options) {
  const Camera& camera = source.snapshot.views[slot]->camera;
  const TileTable& tiles = source.snapshot.tiles;
  const glm::dvec2 size(camera.width, camera.height);
  if (!(image.x >= 0 && image.y >= 0 && image.x < size.x && image.y < size.y)) return 0;
  if (!tiles.whole_views() && !tiles.resident(slot, camera, image.x, image.y)) return 0;
  const auto x = static_cast<std::size_t>(image.x), y = static_cast<std::size_t>(image.y);
  const BlockPixel& shown = source.depths[slot][y * camera.width + x];
  if (cam.z * shown.reciprocal > 1 + options.occlusion_tolerance) return 0;
  const ImageLevel& mask = source.levels[slot].front();
  const double here = mask.rgba[4 * (y * mask.width + x) + 3] / 255.0;
  if (!(here > 0)) return 0;
  // Beside a rim lie invalid pixels of the surface behind it. Neither side takes anything from the other.
  // Past an outline the view sees what is behind the surface, whose validity says nothing about the surface.
  const bool is_past = point.is_continued && (1 + kOutlineStep) * cam.z * shown.reciprocal < 1;
  const double valid = shown.at_rim || is_past
                           ? (is_past ? 1 : here) * rim_share(point.world, novel.center(), camera.center(), options)
                           : bilinear(mask, image).validity;
  return valid * frame_share(image, size, cam.z > source.before_far ? kFarFrameFade : options.frame_fade);
}

WeightedColor color_in_view(const Source& source, ViewSlot slot, const SurfacePoint& point, const Camera& novel,
                            const BlendOptions& options) {
  const auto& [world, z, deviation, is_continued] = point;
  const Snapshot& snapshot = source.snapshot;
  const Camera& camera = snapshot.views[slot]->camera;
  const glm::dvec3 cam = camera.cam_from_world(world);
  if (cam.z <= 0) return {};
  const glm::dvec2 image = camera.image_from_cam(cam);
  const double left = share_left(source, slot, point, cam, image, novel, options);
  if (!(left > 0)) return {};
  const double footprint = options.prefilter ? z * camera.fx / (options.supersample * novel.fx * cam.z) : 1;
  const bool sharp = options.sampling == BlendOptions::Sampling::cubic;
  const std::size_t cubic = sharp ? cubic_levels(snapshot.tiles.options) : 0;
  const double blur =
      blur_of(options.soften ? deviation : 0, novel.center() - world, camera.center() - world, camera.fx, cam.z);
  const glm::dvec3 color =
      filtered(source.levels[slot], image, blur > 0 ? blurred_footprint(footprint, blur) : footprint, cubic);
  const double weight = geometric_weight(world, novel.center(), camera.center(), options);
  return {faded_weight(weight, left), shown_gain(snapshot.gains[slot], color, source.exposure) * color, true};
}

// Returns the share of a view with this weight in a pixel, up to a factor that all views have in common. `best` is the
// largest weight.
double share_of(double weight, double threshold, double best, const BlendOptions& options) {
  if (!(weight > 0)) return 0;
  if (!options.consistent) return weight - threshold;
  const double even = std::min(kEven, kEvenSlope * (1 - best));
  return (weight - threshold) / std::max(1 - weight + even, kLeastPenalty);
}

// Returns the weight of one of several cells that share a pixel: its share, multiplied, as for views, by how good its
// best view is. So a cell that does not refer to the photograph taken from here leaves the pixel to its neighbour that
// does.
double share_of_cell(double share, double best_weight, const BlendOptions& options) {
  return share / (options.consistent ? std::max(1 - best_weight, kLeastPenalty) : 1);
}

// The K best views' mean colour, by what they count, and the weight of the best one. False where no view is valid.
bool blend(const Source& source, std::span<const ViewSlot> slots, const SurfacePoint& point, const Camera& novel,
           const BlendOptions& options, glm::dvec3& color, double& best_weight) {
  std::array<WeightedColor, kMaxBlendedViews + 1> best{};
  const std::size_t kept = options.views + 1;
  for (const ViewSlot slot : slots) {
    WeightedColor next = color_in_view(source, slot, point, novel, options);
    for (std::size_t rank = 0; rank < kept; ++rank) {
      if (next.weight > best[rank].weight) std::swap(next, best[rank]);
    }
  }
  if (!(best[0].weight > 0)) return false;
  best_weight = best[0].weight;
  const double threshold = options.fade_last ? best[options.views].weight : 0;
  double total = 0;
  glm::dvec3 sum(0);
  for (std::size_t rank = 0; rank < options.views; ++rank) {
    const double share = share_of(best[rank].weight, threshold, best_weight, options);
    total += share;
    sum += share * best[rank].color;
  }
  // All K + 1 weigh the same: nothing is left above the last, and the best one stands for them.
  color = total > 0 ? sum / total : best[0].color;
  return true;
}

// Barycentric coordinates of a point on a face, each in [0, 1], sum 1; those of its first corner if it has no area.
glm::dvec3 corner_weights(const Mesh& mesh, std::uint32_t face, const glm::dvec3& world) {
  const glm::uvec3 corners = mesh.faces[face];
  const glm::dvec3 a(mesh.positions[corners.x]);
  const glm::dvec3 b(mesh.positions[corners.y]);
  const glm::dvec3 c(mesh.positions[corners.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double area = glm::dot(normal, normal);
  if (!(area > 0)) return {1, 0, 0};
  const double y = glm::dot(glm::cross(world - a, c - a), normal) / area;
  const double z = glm::dot(glm::cross(b - a, world - a), normal) / area;
  const glm::dvec3 weights = glm::clamp(glm::dvec3(1 - y - z, y, z), 0.0, 1.0);
  return weights / (weights.x + weights.y + weights.z);
}

glm::dvec3 vertex_color(const Snapshot& snapshot, std::uint32_t face, const glm::dvec3& weights) {
  const auto& linear = linear_from_srgb8();
  glm::dvec3 color(0);
  for (int corner = 0; corner < 3; ++corner) {
    const glm::u8vec3 srgb = snapshot.vertex_colors.get()[snapshot.surface->mesh.faces[face][corner]];
    color += weights[corner] * glm::dvec3(linear[srgb.r], linear[srgb.g], linear[srgb.b]);
  }
  return color;
}

// The values that are the same for every pixel of a picture.
struct Picture {
  const Source& source;
  const Camera& camera;
  const VisibilityBuffer& visible;
  const BlendOptions& options;
  const CellShares& shares;
  std::span<const std::uint32_t> from = {};  // the pixel whose surface each shows, see outlines.h; empty: its own
};

glm::dvec4 shares_at(const CellShares& shares, std::uint32_t face, const glm::dvec3& weights) {
  glm::dvec4 sum(0);
  for (int corner = 0; corner < 3; ++corner) {
    sum += weights[corner] * glm::dvec4(shares.corners[face][static_cast<std::size_t>(corner)]);
  }
  return sum;
}

// The mean of what the cells of a face make of a point on it, by their shares. False where no view of any is valid.
bool blend_cells(const Picture& picture, std::uint32_t face, const glm::dvec4& shares, const SurfacePoint& point,
                 glm::dvec3& color) {
  const Snapshot& snapshot = picture.source.snapshot;
  const CellShares::Zone& zone = picture.shares.zones[picture.shares.zone_of_face[face]];
  double total = 0;
  glm::dvec3 sum(0);
  for (int i = 0; i < static_cast<int>(kCellsPerZone); ++i) {
    if (!(shares[i] > 0)) continue;
    glm::dvec3 of_cell;
    double best_weight = 0;
    const auto slots = snapshot.references.of_cell(zone[static_cast<std::size_t>(i)]);
    if (!blend(picture.source, slots, point, picture.camera, picture.options, of_cell, best_weight)) continue;
    const double share = share_of_cell(shares[i], best_weight, picture.options);
    total += share;
    sum += share * of_cell;
  }
  color = sum / total;
  return total > 0;
}

// Returns the deviation of the face's cell, scene units, rounded as the shader reads it (deviation_bits()).
double deviation_at(const Snapshot& snapshot, std::uint32_t face) {
  if (snapshot.cell_deviation.empty()) return 0;
  const float deviation = snapshot.cell_deviation[snapshot.surface->cells.cell_of_face[face]];
  return static_cast<double>(std::bit_cast<float>(deviation_bits(deviation) << 16));
}

struct Shaded {
  PixelState state = PixelState::empty;
  glm::dvec3 color{0.0};  // in the picture's exposure
};

Shaded shade(const Picture& picture, std::size_t pixel) {
  const std::uint32_t face = picture.visible.face[pixel];
  if (face == FaceId::none) return {};
  const Camera& camera = picture.camera;
  const Snapshot& snapshot = picture.source.snapshot;
  const std::size_t x = pixel % camera.width;
  const std::size_t y = pixel / camera.width;
  const glm::dvec2 image(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
  const auto z = static_cast<double>(picture.visible.depth[pixel]);
  const glm::dvec3 world = camera.center() + z * camera.ray(image);
  const std::size_t from = picture.from.empty() ? pixel : picture.from[pixel];
  const std::size_t column = from % camera.width, row = from / camera.width;
  const glm::dvec2 from_image(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
  const glm::dvec3 there = camera.center() + z * camera.ray(from_image);
  const glm::dvec3 weights = corner_weights(snapshot.surface->mesh, face, there);
  Shaded shaded;
  const SurfacePoint point{world, z, deviation_at(snapshot, face), from != pixel};
  if (blend_cells(picture, face, shares_at(picture.shares, face, weights), point, shaded.color)) {
    shaded.state = PixelState::textured;
  } else {
    shaded.color = vertex_color(snapshot, face, weights);
    const CellId cell = snapshot.surface->cells.cell_of_face[face];
    shaded.state = snapshot.cell_seen[cell] ? PixelState::untextured : PixelState::unseen;
  }
  shaded.color *= picture.source.exposure;
  return shaded;
}

// Those that are not `asked` for stay empty.
std::vector<Shaded> shade(const Picture& picture, const std::vector<std::uint8_t>& asked) {
  std::vector<Shaded> pixels(picture.visible.face.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pixels.size(), 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                        if (asked[pixel]) pixels[pixel] = shade(picture, pixel);
                      }
                    });
  return pixels;
}

std::vector<Shaded> shade_all(const Picture& picture) {
  return shade(picture, std::vector<std::uint8_t>(picture.visible.face.size(), 1));
}

// Adds the colours of samples, each as often as it counts, and how often that is.
void add_counted(const std::vector<Shaded>& samples, const std::vector<std::uint8_t>& counts,
                 std::vector<glm::dvec4>& sums) {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (samples[i].state != PixelState::empty)
      sums[i] += static_cast<double>(counts[i]) * glm::dvec4(samples[i].color, 1);
  }
}

// The colours as they are once they are stored in 8 bits.
std::vector<Shaded> cut_off(std::vector<Shaded> pixels) {
  for (Shaded& pixel : pixels) pixel.color = glm::clamp(pixel.color, 0.0, 1.0);
  return pixels;
}

void take_means(const std::vector<glm::dvec4>& sums, std::vector<Shaded>& pixels) {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const bool shown = pixels[i].state != PixelState::empty && sums[i].w > 0;
    if (shown) pixels[i].color = glm::dvec3(sums[i]) / sums[i].w;
  }
}

Rendering rounded(const Camera& camera, const std::vector<Shaded>& pixels) {
  Rendering rendering;
  rendering.picture.width = camera.width;
  rendering.picture.height = camera.height;
  rendering.picture.rgb.reserve(3 * pixels.size());
  rendering.state.reserve(pixels.size());
  for (const Shaded& pixel : pixels) {
    rendering.state.push_back(pixel.state);
    for (int channel = 0; channel < 3; ++channel) {
      rendering.picture.rgb.push_back(srgb8_from_linear(pixel.color[channel]));
    }
  }
  return rendering;
}

// Returns the deviation of each pixel's surface, scene units; 0 where the pixel sees no surface.
std::vector<float> deviations(const Snapshot& snapshot, const VisibilityBuffer& visible) {
  std::vector<float> deviation;
  deviation.reserve(visible.face.size());
  for (const std::uint32_t face : visible.face) {
    deviation.push_back(face == FaceId::none ? 0.0f : static_cast<float>(deviation_at(snapshot, face)));
  }
  return deviation;
}

double most_edge_deviation(const Snapshot& snapshot) {
  return kMostOfMedian * static_cast<double>(median_deviation(snapshot.cell_deviation));
}

// What the middles of pixels show once outlines are continued, and the pixel that it comes from; none: its own.
struct ShownSurface {
  VisibilityBuffer visible;
  std::vector<std::uint32_t> from;
};

ShownSurface with_outlines(const VisibilityBuffer& visible, const Snapshot& snapshot, const Camera& camera,
                           const BlendOptions& options) {
  ShownSurface shown{visible, {}};
  const double most = most_edge_deviation(snapshot);
  if (!options.outlines || !(most > 0)) return shown;
  shown.from = continued_outlines(camera, visible, deviations(snapshot, visible), most);
  for (std::size_t pixel = 0; pixel < shown.from.size(); ++pixel) {
    shown.visible.face[pixel] = visible.face[shown.from[pixel]];
    shown.visible.depth[pixel] = visible.depth[shown.from[pixel]];
  }
  return shown;
}

// The picture with soft edges, if options ask for them. `visible`: what the middles of its pixels see.
Rendering with_soft_edges(Rendering rendering, const Snapshot& snapshot, const Camera& camera,
                          const VisibilityBuffer& visible, const BlendOptions& options) {
  const double most = most_edge_deviation(snapshot);
  if (!options.soft_edges || !(most > 0)) return rendering;
  std::vector<std::uint8_t> seen;
  for (const std::uint32_t face : visible.face) seen.push_back(face == FaceId::none ? 0 : 1);
  rendering.picture =
      with_soft_edges(rendering.picture, seen, edge_blur(camera, visible, deviations(snapshot, visible), most));
  return rendering;
}

PixelDiagnosis diagnose(const Source& source, std::span<const ViewSlot> slots, const SurfacePoint& point,
                        const Camera& novel, const BlendOptions& options) {
  PixelDiagnosis pixel;
  std::vector<double> weights;
  for (const ViewSlot slot : slots) {
    const WeightedColor next = color_in_view(source, slot, point, novel, options);
    if (next.valid) ++pixel.valid_views;
    if (next.weight > 0 && (weights.empty() || next.weight > *std::max_element(weights.begin(), weights.end()))) {
      pixel.winner = slot;
    }
    if (next.weight > 0) weights.push_back(next.weight);
  }
  std::sort(weights.begin(), weights.end(), std::greater<>());
  weights.resize(std::max<std::size_t>(weights.size(), kMaxBlendedViews + 1), 0.0);
  const double threshold = options.fade_last ? weights[options.views] : 0;
  double total = 0;
  for (std::size_t rank = 0; rank < options.views; ++rank)
    total += share_of(weights[rank], threshold, weights[0], options);
  for (std::size_t rank = 0; rank < std::min<std::size_t>(3, options.views) && total > 0; ++rank) {
    pixel.shares[rank] = static_cast<float>(share_of(weights[rank], threshold, weights[0], options) / total);
  }
  if (total == 0 && pixel.winner != ViewSlot::none) pixel.shares[0] = 1;  // the same as in blend()
  return pixel;
}

void require_buffer_of(const Camera& camera, const VisibilityBuffer& visible, std::size_t faces) {
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  if (visible.width != camera.width || visible.height != camera.height || visible.depth.size() != pixels ||
      visible.face.size() != pixels) {
    throw std::invalid_argument("reference renderer: the visibility buffer must be as large as the camera's image");
  }
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    if (visible.face[pixel] == FaceId::none || visible.face[pixel] < faces) continue;
    throw std::invalid_argument("reference renderer: pixel " + std::to_string(pixel) +
                                " of the visibility buffer shows face " + std::to_string(visible.face[pixel]) +
                                ", the mesh has " + std::to_string(faces));
  }
}

}  // namespace

Diagnosis diagnose_reference(const Snapshot& snapshot, const Camera& camera, const VisibilityBuffer& visible,
                             const BlendOptions& options) {
  BlendOptions of_own_cell = at_middle(options);
  of_own_cell.border_width = 0;
  Diagnosis diagnosis{camera.width, camera.height, render_reference(snapshot, camera, visible, of_own_cell).state, {}};
  diagnosis.pixels.resize(diagnosis.state.size());
  const Source source(snapshot, options, glm::dvec3(1));
  const auto [shown, from] = with_outlines(visible, snapshot, camera, options);
  tbb::parallel_for(std::size_t{0}, diagnosis.pixels.size(), [&, &shown = shown, &from = from](std::size_t pixel) {
    const std::uint32_t face = shown.face[pixel];
    if (face == FaceId::none) return;
    const std::size_t x = pixel % camera.width;
    const std::size_t y = pixel / camera.width;
    const glm::dvec2 image(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
    const auto z = static_cast<double>(shown.depth[pixel]);
    const glm::dvec3 world = camera.center() + z * camera.ray(image);
    const bool is_continued = !from.empty() && from[pixel] != pixel;
    const CellId cell = snapshot.surface->cells.cell_of_face[face];
    diagnosis.pixels[pixel] =
        diagnose(source, snapshot.references.of_cell(cell), {world, z, 0, is_continued}, camera, of_own_cell);
  });
  return diagnosis;
}

Rendering render_reference(const Snapshot& snapshot, const Camera& camera, const VisibilityBuffer& visible,
                           const BlendOptions& options) {
  check(options);
  check(camera);
  check(snapshot);
  require_buffer_of(camera, visible, snapshot.surface->mesh.faces.size());
  const Source source(snapshot, options, picture_exposure(NearbyExposure(snapshot), camera, options));
  const CellShares shares = share_cells(*snapshot.surface, options.border_width * snapshot.surface->cells.size);
  const auto [shown, from] = with_outlines(visible, snapshot, camera, options);
  return with_soft_edges(rounded(camera, shade_all({source, camera, shown, at_middle(options), shares, from})),
                         snapshot, camera, shown, options);
}

Rendering render_reference(const Snapshot& snapshot, const Camera& camera, const Visibility& visibility,
                           const BlendOptions& options) {
  check(options);
  check(camera);
  check(snapshot);
  const Source source(snapshot, options, picture_exposure(NearbyExposure(snapshot), camera, options));
  const CellShares shares = share_cells(*snapshot.surface, options.border_width * snapshot.surface->cells.size);
  const auto [visible, from] = with_outlines(visibility.trace(camera), snapshot, camera, options);
  std::vector<Shaded> pixels = shade_all({source, camera, visible, at_middle(options), shares, from});
  if (options.supersample == 1) return with_soft_edges(rounded(camera, pixels), snapshot, camera, visible, options);
  std::vector<std::uint8_t> sampled = options.antialias == BlendOptions::Antialias::all
                                          ? std::vector<std::uint8_t>(pixels.size(), 1)
                                          : silhouettes(camera, visible);
  // Samples know nothing of what is continued past outlines.
  for (std::size_t pixel = 0; pixel < from.size(); ++pixel) {
    if (from[pixel] != pixel) sampled[pixel] = 0;
  }
  std::vector<VisibilityBuffer> visible_samples;
  const std::vector<Camera> samples = sample_cameras(camera, options.supersample);
  visible_samples.reserve(samples.size());
  for (const Camera& sample : samples) visible_samples.push_back(visibility.trace(sample));
  const SampleCounts counts = sample_counts(camera, visible, visible_samples, sampled, options.antialias);
  std::vector<glm::dvec4> sums(pixels.size(), glm::dvec4(0));  // colour, and how many samples see the surface
  add_counted(cut_off(pixels), counts.middle, sums);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    add_counted(shade({source, samples[i], visible_samples[i], options, shares}, counts.samples[i]), counts.samples[i],
                sums);
  }
  take_means(sums, pixels);
  return with_soft_edges(rounded(camera, pixels), snapshot, camera, visible, options);
}

}  // namespace lumatlas
