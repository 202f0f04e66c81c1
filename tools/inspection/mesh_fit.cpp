// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/mesh_fit.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <map>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "tools/base/process/interrupt.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

// Arrays have one entry a pixel, row by row from the top left.
struct SmallPicture {
  std::uint32_t width = 0, height = 0;
  std::vector<glm::vec3> color;  // sRGB, [0, 1]
  std::vector<float> band;       // luma in the band of wavelengths
  std::vector<std::uint8_t> valid;
  std::vector<std::uint8_t> black;  // 1 where all pixels of the photograph that are valid are black
};

namespace {

constexpr Requirement mesh_fit_requires{"mesh fit"};
constexpr std::uint8_t kBlack = 12;  // 8-bit level that JPEG leaves in what was black, at most

// ---- Which photographs -----------------------------------------------------------------------------------------

// Ranks, nearest first, of the views that look about the same way.
std::vector<std::size_t> neighbours_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                                       std::size_t seed) {
  constexpr double kSameWay = 0.64;  // cosine of 50 degrees
  const glm::dvec3 center = views[seed].camera.center();
  const glm::dvec3 direction = views[seed].camera.viewing_direction();
  std::vector<std::pair<double, std::size_t>> near;
  for (const std::size_t rank : ranks) {
    if (rank == seed || glm::dot(views[rank].camera.viewing_direction(), direction) < kSameWay) continue;
    near.emplace_back(glm::distance(views[rank].camera.center(), center), rank);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::size_t> result;
  for (const auto& [distance, rank] : near) result.push_back(rank);
  return result;
}

// Evenly spread seeds, each with two neighbours: of a stream, not the next frames, which show the same whatever the
// surface is.
std::vector<std::size_t> chosen_views(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                                      std::size_t most) {
  if (ranks.size() <= most) return ranks;
  std::vector<std::size_t> chosen;
  const auto add = [&](std::size_t rank) {
    if (std::find(chosen.begin(), chosen.end(), rank) == chosen.end()) chosen.push_back(rank);
  };
  const std::size_t seeds = std::max<std::size_t>(most / 3, 1);
  for (std::size_t i = 0; i < seeds; ++i) {
    const std::size_t seed = ranks[(2 * i + 1) * ranks.size() / (2 * seeds)];
    add(seed);
    const std::vector<std::size_t> near = neighbours_of(views, ranks, seed);
    for (const std::size_t nth : {ranks.size() / 50, ranks.size() / 20}) {
      if (nth < near.size()) add(near[nth]);
    }
  }
  return chosen;
}

// ---- Small pictures --------------------------------------------------------------------------------------------

// Means over the pixels that fall into each small one; valid where at least half of them are.
SmallPicture shrunk(const Photograph& photograph, const Camera& small) {
  SmallPicture picture{small.width, small.height, {}, {}, {}, {}};
  const std::size_t pixels = std::size_t{small.width} * small.height;
  picture.color.assign(pixels, glm::vec3(0));
  picture.valid.assign(pixels, 0);
  picture.black.assign(pixels, 1);
  std::vector<float> count(pixels, 0), all(pixels, 0);
  for (std::uint32_t y = 0; y < photograph.height; ++y) {
    const std::size_t row = std::uint64_t{y} * small.height / photograph.height;
    for (std::uint32_t x = 0; x < photograph.width; ++x) {
      const std::size_t pixel = std::size_t{y} * photograph.width + x;
      const std::size_t at = row * small.width + std::uint64_t{x} * small.width / photograph.width;
      all[at] += 1;
      if (!photograph.valid.empty() && photograph.valid[pixel] == 0) continue;
      count[at] += 1;
      const std::uint8_t* const rgb = &photograph.rgb[3 * pixel];
      picture.color[at] += glm::vec3(rgb[0], rgb[1], rgb[2]);
      if (std::max({rgb[0], rgb[1], rgb[2]}) > kBlack) picture.black[at] = 0;
    }
  }
  for (std::size_t i = 0; i < pixels; ++i) {
    picture.valid[i] = count[i] > 0 && 2 * count[i] >= all[i] ? 1 : 0;
    if (count[i] > 0) picture.color[i] /= 255 * count[i];
    if (picture.valid[i] == 0) picture.black[i] = 0;
  }
  return picture;
}

// Means over windows of 2 radius + 1 pixels along one direction, over valid pixels; `weight` becomes that of the means.
void blur_along(std::vector<float>& values, std::vector<float>& weight, std::size_t lines, std::size_t length,
                std::size_t line_stride, std::size_t stride, int radius) {
  std::vector<float> sums(length), weights(length);
  for (std::size_t line = 0; line < lines; ++line) {
    for (std::size_t i = 0; i < length; ++i) {
      float sum = 0, total = 0;
      const std::size_t first = i > static_cast<std::size_t>(radius) ? i - static_cast<std::size_t>(radius) : 0;
      const std::size_t last = std::min(length - 1, i + static_cast<std::size_t>(radius));
      for (std::size_t j = first; j <= last; ++j) {
        const std::size_t at = line * line_stride + j * stride;
        sum += weight[at] * values[at];
        total += weight[at];
      }
      sums[i] = total > 0 ? sum / total : 0;
      weights[i] = total;
    }
    for (std::size_t i = 0; i < length; ++i) {
      values[line * line_stride + i * stride] = sums[i];
      weight[line * line_stride + i * stride] = weights[i];
    }
  }
}

std::vector<float> blurred(const SmallPicture& picture, std::vector<float> values, int radius) {
  std::vector<float> weight(picture.valid.begin(), picture.valid.end());
  blur_along(values, weight, picture.height, picture.width, picture.width, 1, radius);
  blur_along(values, weight, picture.width, picture.height, 1, picture.width, radius);
  return values;
}

void add_band(SmallPicture& picture) {
  constexpr int kFine = 1, kCoarse = 4;
  std::vector<float> luma(picture.color.size());
  std::transform(picture.color.begin(), picture.color.end(), luma.begin(),
                 [](const glm::vec3& c) { return glm::dot(c, glm::vec3(0.299f, 0.587f, 0.114f)); });
  picture.band = blurred(picture, luma, kFine);
  const std::vector<float> coarse = blurred(picture, std::move(luma), kCoarse);
  for (std::size_t i = 0; i < coarse.size(); ++i) picture.band[i] -= coarse[i];
}

// Returns the marked pixels that other marked pixels join to the picture's edge.
std::vector<std::uint8_t> joined_to_edge(std::vector<std::uint8_t> marked, std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint8_t> joined(marked.size(), 0);
  std::vector<std::size_t> open;
  const auto take = [&](std::size_t pixel) {
    if (marked[pixel] == 0) return;
    marked[pixel] = 0;
    joined[pixel] = 1;
    open.push_back(pixel);
  };
  for (std::size_t pixel = 0; pixel < marked.size(); ++pixel) {
    const std::size_t x = pixel % width, y = pixel / width;
    if (x == 0 || y == 0 || x + 1 == width || y + 1 == height) take(pixel);
  }
  while (!open.empty()) {
    const std::size_t pixel = open.back();
    open.pop_back();
    if (pixel % width > 0) take(pixel - 1);
    if (pixel % width + 1 < width) take(pixel + 1);
    if (pixel >= width) take(pixel - width);
    if (pixel + width < joined.size()) take(pixel + width);
  }
  return joined;
}

// Returns the picture as it was before the change. A picture that is not square cannot have been turned by an odd
// number of quarters.
SmallPicture undone(const SmallPicture& picture, const PictureChange& change) {
  SmallPicture result = picture;
  const std::uint32_t w = picture.width, h = picture.height;
  const std::uint32_t turns = w == h ? change.quarter_turns % 4 : change.quarter_turns % 4 / 2 * 2;
  for (std::uint32_t y = 0; y < h; ++y) {
    for (std::uint32_t x = 0; x < w; ++x) {
      std::uint32_t fx = x, fy = y;
      for (std::uint32_t i = 0; i < turns % 2; ++i) fx = w - 1 - y, fy = x;
      if (turns == 2) fx = w - 1 - x, fy = h - 1 - y;
      if (turns == 3) fx = y, fy = h - 1 - x;
      if (change.mirrored) fx = w - 1 - fx;
      const std::size_t to = std::size_t{y} * w + x, from = std::size_t{fy} * w + fx;
      result.color[to] = picture.color[from];
      result.band[to] = picture.band[from];
      result.valid[to] = picture.valid[from];
    }
  }
  return result;
}

// ---- What they show of the mesh --------------------------------------------------------------------------------

// A view of the mesh as it is in its file, where a change says how that lies in the world. Where the change mirrors,
// the camera does too: `flipped` says that columns run from right to left.
struct ChangedCamera {
  Camera camera;
  bool flipped = false;

  [[nodiscard]] std::uint32_t column(std::uint32_t x) const { return flipped ? camera.width - 1 - x : x; }
};

ChangedCamera changed(Camera camera, const MeshFrame& change, const glm::dvec3& offset) {
  const glm::dmat3 rotation = camera.cam_from_world_rotation;
  const glm::dvec3 moved = change.scale * (change.axes * offset) + change.shift - offset;
  camera.cam_from_world_rotation = rotation * change.axes;
  camera.cam_from_world_translation = (camera.cam_from_world_translation + rotation * moved) / change.scale;
  const bool flipped = glm::determinant(change.axes) < 0;
  if (flipped) {
    const glm::dmat3 flip(-1, 0, 0, 0, 1, 0, 0, 0, 1);
    camera.cam_from_world_rotation = flip * camera.cam_from_world_rotation;
    camera.cam_from_world_translation = flip * camera.cam_from_world_translation;
    camera.cx = camera.width - camera.cx;
  }
  return {camera, flipped};
}

// Returns nothing for a point in the camera's frame that is behind it or outside its image.
std::optional<std::size_t> pixel_of(const Camera& camera, const glm::dvec3& cam) {
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 image = camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < camera.width && image.y < camera.height)) return std::nullopt;
  return static_cast<std::size_t>(image.y) * camera.width + static_cast<std::size_t>(image.x);
}

struct FitLook {
  ChangedCamera camera;
  VisibilityBuffer visible;
};

// The points that one picture shows and another shows too: pixels of both.
struct SharedPoints {
  std::vector<std::size_t> from, to;
};

SharedPoints shared_points(const FitLook& a, const SmallPicture& picture_a, const FitLook& b,
                           const SmallPicture& picture_b, const MeshFitOptions& options) {
  SharedPoints shared;
  const Camera& camera_a = a.camera.camera;
  const Camera& camera_b = b.camera.camera;
  const glm::dvec3 center = camera_a.center();
  for (std::uint32_t y = options.step_px / 2; y < camera_a.height; y += options.step_px) {
    for (std::uint32_t x = options.step_px / 2; x < camera_a.width; x += options.step_px) {
      const std::size_t pixel = std::size_t{y} * camera_a.width + x;
      const std::size_t from = std::size_t{y} * camera_a.width + a.camera.column(x);
      if (a.visible.face[pixel] == FaceId::none || picture_a.valid[from] == 0) continue;
      const glm::dvec3 world = center + double{a.visible.depth[pixel]} * camera_a.ray({x + 0.5, y + 0.5});
      const glm::dvec3 cam = camera_b.cam_from_world(world);
      const std::optional<std::size_t> seen = pixel_of(camera_b, cam);
      if (!seen) continue;
      const auto column = static_cast<std::uint32_t>(*seen % camera_b.width);
      const std::size_t to = *seen - column + b.camera.column(column);
      if (picture_b.valid[to] == 0 || b.visible.face[*seen] == FaceId::none) continue;
      if (std::abs(double{b.visible.depth[*seen]} - cam.z) > options.same_depth * cam.z) continue;
      shared.from.push_back(from);
      shared.to.push_back(to);
    }
  }
  return shared;
}

double correlation_of(const SmallPicture& a, const SmallPicture& b, const SharedPoints& shared) {
  double aa = 0, bb = 0, ab = 0;
  for (std::size_t i = 0; i < shared.from.size(); ++i) {
    const double first = static_cast<double>(a.band[shared.from[i]]),
                 second = static_cast<double>(b.band[shared.to[i]]);
    aa += first * first;
    bb += second * second;
    ab += first * second;
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

// The differences of colour at the points after one gain, root mean square over the channels.
void add_differences(const SmallPicture& a, const SmallPicture& b, const SharedPoints& shared,
                     std::vector<double>& differences) {
  std::vector<float> ratios;
  for (std::size_t i = 0; i < shared.from.size(); ++i) {
    const float from = a.color[shared.from[i]].g, to = b.color[shared.to[i]].g;
    if (to > 0) ratios.push_back(from / to);
  }
  const float gain = ratios.empty() ? 1 : upper_median(ratios);
  for (std::size_t i = 0; i < shared.from.size(); ++i) {
    const glm::vec3 d = a.color[shared.from[i]] - gain * b.color[shared.to[i]];
    differences.push_back(std::sqrt(static_cast<double>(glm::dot(d, d)) / 3));
  }
}

}  // namespace

void check(const MeshFitOptions& options) {
  mesh_fit_requires(options.views >= 2, "views", options.views, "at least 2");
  mesh_fit_requires(options.longer_px >= 32, "longer_px", options.longer_px, "at least 32");
  mesh_fit_requires(options.step_px >= 1, "step_px", options.step_px, "at least 1");
  mesh_fit_requires(options.least_points >= 1, "least_points", options.least_points, "at least 1");
  mesh_fit_requires(options.same_depth > 0 && options.same_depth < 1, "same_depth", options.same_depth, "in (0, 1)");
  mesh_fit_requires(options.outlier > 0 && options.outlier < 1, "outlier", options.outlier, "in (0, 1)");
}

MeshFitMeter::MeshFitMeter(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                           const Visibility& visibility, const glm::dvec3& offset, const MeshFitOptions& options)
    : views_(views), visibility_(visibility), offset_(offset), options_(options) {
  check(options);
  chosen_ = chosen_views(views, ranks, options.views);
  pictures_.resize(chosen_.size());
  std::vector<std::uint8_t> can_be_read(chosen_.size(), 1);
  for_each_index(chosen_.size(), [&](std::size_t i) {
    const SceneView& view = views_[chosen_[i]];
    try {
      pictures_[i] = shrunk(load_photograph(view), view.camera.shrunk_to(options_.longer_px));
    } catch (const InputError&) {
      can_be_read[i] = 0;
    }
  });
  for (std::size_t i = chosen_.size(); i-- > 0;) {
    if (can_be_read[i] != 0) continue;
    chosen_.erase(chosen_.begin() + static_cast<std::ptrdiff_t>(i));
    pictures_.erase(pictures_.begin() + static_cast<std::ptrdiff_t>(i));
  }
  leave_out_borders();
  for (SmallPicture& picture : pictures_) add_band(picture);
}

void MeshFitMeter::leave_out_borders() {
  constexpr std::size_t kFewest = 3;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<SmallPicture*>> by_size;
  for (SmallPicture& picture : pictures_) by_size[{picture.width, picture.height}].push_back(&picture);
  for (const auto& [size, pictures] : by_size) {
    if (pictures.size() < kFewest) continue;
    std::vector<std::uint8_t> black = pictures.front()->black;
    for (const SmallPicture* const picture : pictures) {
      for (std::size_t i = 0; i < black.size(); ++i) black[i] = black[i] & picture->black[i];
    }
    const std::vector<std::uint8_t> border = joined_to_edge(std::move(black), size.first, size.second);
    const auto pixels = static_cast<double>(std::count(border.begin(), border.end(), 1));
    black_border_ = std::max(black_border_, pixels / static_cast<double>(border.size()));
    for (SmallPicture* const picture : pictures) {
      for (std::size_t i = 0; i < border.size(); ++i) {
        if (border[i] != 0) picture->valid[i] = 0;
      }
    }
  }
}

double MeshFitMeter::points_on_mesh(const ScenePoints& points, double same_place) const {
  constexpr std::size_t kMostPoints = 20000, kFewestPoints = 50;
  std::vector<FitLook> looks(chosen_.size());
  for_each_index(chosen_.size(), [&](std::size_t i) {
    looks[i].camera.camera = views_[chosen_[i]].camera.shrunk_to(options_.longer_px);
    visibility_.trace(looks[i].camera.camera, looks[i].visible);
  });
  std::size_t seen = 0, on_mesh = 0;
  const std::size_t stride = points.positions.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < points.positions.size(); i += stride) {
    std::size_t in_views = 0, on_faces = 0;
    for (std::size_t look = 0; look < looks.size(); ++look) {
      const std::vector<std::uint32_t>& ranks = points.views[i];
      if (!ranks.empty() && !std::binary_search(ranks.begin(), ranks.end(), chosen_[look])) continue;
      const Camera& camera = looks[look].camera.camera;
      const glm::dvec3 cam = camera.cam_from_world(points.positions[i] - offset_);
      const std::optional<std::size_t> pixel = pixel_of(camera, cam);
      if (!pixel) continue;
      ++in_views;
      const bool on_face = looks[look].visible.face[*pixel] != FaceId::none;
      const double depth = double{looks[look].visible.depth[*pixel]};
      on_faces += on_face && std::abs(depth - cam.z) <= same_place * cam.z ? 1 : 0;
    }
    // A point without a list of the views that saw it may be hidden in most.
    const std::size_t needed = points.views[i].empty() ? 1 : (in_views + 1) / 2;
    seen += in_views > 0 ? 1 : 0;
    on_mesh += in_views > 0 && on_faces >= needed ? 1 : 0;
  }
  if (seen < kFewestPoints) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(on_mesh) / static_cast<double>(seen);
}

MeshFitMeter::~MeshFitMeter() = default;

MeshFit MeshFitMeter::measure(const MeshFrame& mesh, const PictureChange& picture) const {
  throw_if_interrupted();
  std::vector<FitLook> looks(chosen_.size());
  std::vector<SmallPicture> pictures(chosen_.size());
  for_each_index(chosen_.size(), [&](std::size_t i) {
    looks[i].camera = changed(views_[chosen_[i]].camera.shrunk_to(options_.longer_px), mesh, offset_);
    visibility_.trace(looks[i].camera.camera, looks[i].visible);
    pictures[i] = undone(pictures_[i], picture);
  });
  MeshFit fit;
  std::vector<double> correlations, differences;
  for (std::size_t a = 0; a < looks.size(); ++a) {
    for (std::size_t b = 0; b < looks.size(); ++b) {
      if (a == b) continue;
      const SharedPoints shared = shared_points(looks[a], pictures[a], looks[b], pictures[b], options_);
      if (shared.from.size() < options_.least_points) continue;
      ++fit.pairs;
      fit.points += shared.from.size();
      correlations.push_back(correlation_of(pictures[a], pictures[b], shared));
      add_differences(pictures[a], pictures[b], shared, differences);
    }
  }
  if (fit.pairs == 0) {
    fit.correlation = fit.residual = fit.outliers = std::numeric_limits<double>::quiet_NaN();
    return fit;
  }
  fit.correlation = upper_median(correlations);
  double squares = 0;
  std::size_t outliers = 0;
  for (const double d : differences) {
    squares += std::min(d, options_.outlier) * std::min(d, options_.outlier);
    outliers += d > options_.outlier ? 1 : 0;
  }
  fit.residual = std::sqrt(squares / static_cast<double>(differences.size()));
  fit.outliers = static_cast<double>(outliers) / static_cast<double>(differences.size());
  return fit;
}

}  // namespace lumatlas
