// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/bench/refinement_time.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "planner/surface_distance.h"
#include "tools/scene/photograph_stream.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

namespace {

// The old pixels that a new one is made of along one axis, with weights that add up to 1.
struct Taps {
  std::uint32_t first = 0;
  std::vector<float> weights;
};

std::vector<Taps> taps_along(std::uint32_t from, std::uint32_t to) {
  const double scale = static_cast<double>(from) / to;
  const double reach = std::max(1.0, scale);
  std::vector<Taps> taps(to);
  for (std::uint32_t i = 0; i < to; ++i) {
    const double center = (i + 0.5) * scale - 0.5;
    const double least = std::clamp(std::floor(center - reach) + 1, 0.0, from - 1.0);
    const double most = std::clamp(std::ceil(center + reach) - 1, least, from - 1.0);
    taps[i].first = static_cast<std::uint32_t>(least);
    double sum = 0;
    for (double at = least; at <= most; ++at) sum += 1 - std::min(1.0, std::abs(at - center) / reach);
    for (double at = least; at <= most; ++at) {
      const double weight = 1 - std::min(1.0, std::abs(at - center) / reach);
      taps[i].weights.push_back(static_cast<float>(sum > 0 ? weight / sum : at == least));
    }
  }
  return taps;
}

// One row of the photograph, resampled along it.
std::vector<float> narrowed(const std::uint8_t* row, const std::vector<Taps>& columns) {
  std::vector<float> result(3 * columns.size(), 0.0f);
  for (std::size_t x = 0; x < columns.size(); ++x) {
    for (std::size_t tap = 0; tap < columns[x].weights.size(); ++tap) {
      const std::uint8_t* pixel = row + 3 * (columns[x].first + tap);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        result[3 * x + channel] += columns[x].weights[tap] * static_cast<float>(pixel[channel]);
      }
    }
  }
  return result;
}

std::vector<std::uint8_t> nearest_mask(const Photograph& photograph, std::uint32_t width, std::uint32_t height) {
  std::vector<std::uint8_t> mask;
  if (photograph.valid.empty()) return mask;
  mask.reserve(std::size_t{width} * height);
  for (std::uint32_t y = 0; y < height; ++y) {
    const auto row = static_cast<std::size_t>((y + 0.5) * photograph.height / height);
    for (std::uint32_t x = 0; x < width; ++x) {
      mask.push_back(
          photograph.valid[row * photograph.width + static_cast<std::size_t>((x + 0.5) * photograph.width / width)]);
    }
  }
  return mask;
}

std::vector<std::size_t> evenly_spaced(std::size_t count) {
  const std::size_t taken = std::min(count, kMostTimedViews);
  std::vector<std::size_t> ranks;
  for (std::size_t i = 0; i < taken; ++i) ranks.push_back(i * count / taken);
  return ranks;
}

Camera sized(const Camera& camera, std::optional<double> megapixels) {
  if (!megapixels) return camera;
  const double scale = std::sqrt(*megapixels * 1e6 / (static_cast<double>(camera.width) * camera.height));
  const auto side = [scale](std::uint32_t pixels) {
    return static_cast<std::uint32_t>(std::max(1.0, std::round(scale * pixels)));
  };
  return camera.scaled_to(side(camera.width), side(camera.height));
}

std::vector<Camera> sized_cameras(const SceneViews& scene, const std::vector<std::size_t>& ranks,
                                  std::optional<double> megapixels) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(sized(scene.views[rank].camera, megapixels));
  return cameras;
}

}  // namespace

Photograph resampled(const Photograph& photograph, std::uint32_t width, std::uint32_t height) {
  if (photograph.width == width && photograph.height == height) return photograph;
  const std::vector<Taps> columns = taps_along(photograph.width, width);
  const std::vector<Taps> rows = taps_along(photograph.height, height);
  std::vector<std::vector<float>> narrow(photograph.height);
  tbb::parallel_for(0u, photograph.height, [&](std::uint32_t y) {
    narrow[y] = narrowed(&photograph.rgb[3 * std::size_t{y} * photograph.width], columns);
  });
  Photograph result{width, height, {}, nearest_mask(photograph, width, height)};
  const std::size_t stride = 3 * std::size_t{width};
  result.rgb.resize(stride * height);
  tbb::parallel_for(0u, height, [&](std::uint32_t y) {
    for (std::size_t i = 0; i < stride; ++i) {
      float sum = 0;
      for (std::size_t tap = 0; tap < rows[y].weights.size(); ++tap) {
        sum += rows[y].weights[tap] * narrow[rows[y].first + tap][i];
      }
      result.rgb[y * stride + i] = static_cast<std::uint8_t>(std::clamp(std::round(sum), 0.0f, 255.0f));
    }
  });
  return result;
}

RefinementTimes time_refinement(const std::filesystem::path& scene, const std::optional<std::filesystem::path>& mesh,
                                const PlannerOptions& options, std::optional<double> megapixels) {
  const SurfaceInput input = load_surface(scene, mesh, {});
  const SceneViews views = read_scene_views(scene, input.surface->offset);
  const std::vector<std::size_t> ranks = evenly_spaced(views.views.size());
  const std::vector<Camera> cameras = sized_cameras(views, ranks, megapixels);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(input.surface->mesh);
  PlannerOptions effective = options;
  effective.coverage.ideal_distance = median_surface_distance(cameras, *visibility);
  Atlas atlas(input.surface, static_cast<std::uint32_t>(ranks.size()));
  Planner planner(atlas, *visibility, effective);
  PhotographStream photographs(views.views, ranks);
  std::vector<double> refine_ms;
  RefinementTimes times;
  for (std::size_t i = 0; i < ranks.size(); ++i) {
    const Camera& camera = cameras[i];
    Photograph photograph = resampled(photographs.next(), camera.width, camera.height);
    const Verdict verdict = planner.offer(views.views[ranks[i]].name, camera, std::move(photograph));
    if (!verdict.refinement) continue;
    refine_ms.push_back(verdict.refine_ms);
    times.megapixels += 1e-6 * camera.width * camera.height;
  }
  times.refined = refine_ms.size();
  times.megapixels /= static_cast<double>(std::max<std::size_t>(times.refined, 1));
  times.median_ms = percentile(refine_ms, 0.5);
  times.p95_ms = percentile(refine_ms, 0.95);
  return times;
}

}  // namespace lumatlas
