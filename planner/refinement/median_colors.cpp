// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/median_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kOcclusionTolerance = 0.02;  // share of the depth, as in blending
constexpr std::uint8_t kLeastTrust = 128;     // of a pixel that is not contradicted
constexpr double kDarkest = 0.0024;           // linear light of kDarkestSample
constexpr double kBrightest = 0.93;           // and of kBrightestSample
constexpr std::uint32_t kFewestRatioPoints = 20;

constexpr Requirement median_colors_requires{"median colours"};

// The position of a point in an image, and its z.
struct Projection {
  glm::dvec2 image;
  double z;
};

// Returns nothing outside the image or behind the camera.
std::optional<Projection> projection(const Camera& camera, const glm::dvec3& position) {
  const glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 image = camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < camera.width && image.y < camera.height)) return std::nullopt;
  return Projection{image, cam.z};
}

struct Sighting {
  Projection at;    // by the present pose, where the colour is
  Projection made;  // by the pose that depth and its edges were made with
};

std::optional<Sighting> sighting(const ComparedView& view, const glm::dvec3& position) {
  const std::optional<Projection> at = projection(view.camera, position);
  if (!at) return std::nullopt;
  const std::optional<Projection> made = projection(view.view->camera, position);
  if (!made) return std::nullopt;
  return Sighting{*at, *made};
}

std::size_t pixel_at(const StoredView& view, const glm::dvec2& image) {
  return static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
}

// Returns whether the photograph's pixel may be used: the lens shows it, and other views do not contradict it.
bool is_usable(const StoredView& view, std::size_t pixel) {
  return view.photograph->is_inside_lens(pixel) && (view.mask->trust.empty() || view.mask->trust[pixel] >= kLeastTrust);
}

// Neither occluded nor masked; where the mask fades counts as well as elsewhere.
bool shows_well(const StoredView& view, const Sighting& seen) {
  const std::size_t pixel = pixel_at(view, seen.made.image);
  if (view.mask->validity[pixel] == 0 || !is_usable(view, pixel)) return false;
  if (seen.made.z > static_cast<double>(view.mask->depth[pixel]) * (1 + kOcclusionTolerance)) return false;
  const std::size_t shown = pixel_at(view, seen.at.image);
  return shown == pixel || is_usable(view, shown);
}

// See Pyramid::prefetch().
void prefetch(const ComparedView& other, const Sighting& seen) {
  const std::size_t pixel = pixel_at(*other.view, seen.made.image);
  other.view->mask->validity.prefetch(pixel);
  other.view->mask->depth.prefetch(pixel);
  other.pyramid.prefetch(0, seen.at.image);
}

// The level of a view's pyramid whose pixels are about as large on the surface as `pixel_size`.
std::uint32_t matching_level(const ComparedView& other, double z, double pixel_size) {
  const double level = std::round(std::log2(pixel_size * other.camera.fx / z));
  return static_cast<std::uint32_t>(std::clamp(level, 0.0, other.pyramid.levels() - 1.0));
}

bool is_informative(const glm::dvec3& color) {
  const double most = std::max({color.r, color.g, color.b});
  return most >= kDarkest && most <= kBrightest;
}

glm::vec3 channel_medians(const std::vector<glm::dvec3>& colors) {
  glm::vec3 medians(0);
  std::vector<double> values(colors.size());
  for (int channel = 0; channel < 3; ++channel) {
    for (std::size_t i = 0; i < colors.size(); ++i) values[i] = colors[i][channel];
    medians[channel] = static_cast<float>(median(values));
  }
  return medians;
}

struct SeenBy {
  ViewSlot slot;
  Sighting seen;
};

// The colours that views show at one sample of the surface.
struct PointColors {
  std::vector<glm::vec3> medians;  // one per level that is needed; empty: no view shows it
  struct Ratio {
    ViewSlot slot;
    glm::dvec3 log_ratio;
    double log_luminance;
  };
  std::vector<Ratio> ratios;
};

class ViewComparison {
 public:
  ViewComparison(const Camera& camera, const Pyramid& photograph, const Atlas& atlas,
                 std::span<const std::optional<ComparedView>> views, std::optional<ViewSlot> except,
                 const AlignmentOptions& alignment)
      : camera_(camera), photograph_(photograph), atlas_(atlas), views_(views), except_(except) {
    for (std::uint32_t level = 0; level < photograph.levels(); ++level) {
      needed_.push_back(needs_level(alignment, photograph, level));
    }
  }

  [[nodiscard]] PointColors at(const SurfaceSample& sample) const {
    PointColors result;
    const std::vector<SeenBy> seen = observations(sample);
    if (seen.empty()) return result;
    const double z = camera_.cam_from_world(sample.position).z;
    std::vector<glm::dvec3> colors(seen.size());
    result.medians.resize(photograph_.levels());
    for (std::uint32_t level = 0; level < photograph_.levels(); ++level) {
      if (!needed_[level] && level != ratio_level()) continue;
      const double pixel_size = z / camera_.fx * static_cast<double>(1u << level);
      for (const SeenBy& by : seen) {
        const ComparedView& other = *views_[by.slot];
        other.pyramid.prefetch(matching_level(other, by.seen.at.z, pixel_size), by.seen.at.image);
      }
      for (std::size_t i = 0; i < seen.size(); ++i) {
        const ComparedView& other = *views_[seen[i].slot];
        const glm::dvec3 raw =
            other.pyramid.color(matching_level(other, seen[i].seen.at.z, pixel_size), seen[i].seen.at.image);
        colors[i] = other.gain * raw;
        if (level == ratio_level()) add_ratio(result, seen[i].slot, raw, photograph_.color(level, sample.image));
      }
      if (needed_[level]) result.medians[level] = channel_medians(colors);
    }
    return result;
  }

 private:
  // Blurred enough that a pixel of misalignment does not matter.
  [[nodiscard]] std::uint32_t ratio_level() const { return std::min(2u, photograph_.levels() - 1); }

  [[nodiscard]] std::vector<SeenBy> observations(const SurfaceSample& sample) const {
    std::vector<SeenBy> seen;
    const CellId cell = atlas_.surface()->cells.cell_of_face[sample.face];
    for (const ViewSlot slot : atlas_.references(cell)) {
      if (slot == except_ || !views_[slot]) continue;
      const std::optional<Sighting> at = sighting(*views_[slot], sample.position);
      if (!at) continue;
      prefetch(*views_[slot], *at);
      seen.push_back({slot, *at});
    }
    std::erase_if(seen, [&](const SeenBy& by) {
      const ComparedView& other = *views_[by.slot];
      return !shows_well(*other.view, by.seen) || !is_informative(other.pyramid.color(0, by.seen.at.image));
    });
    return seen;
  }

  static void add_ratio(PointColors& result, ViewSlot slot, const glm::dvec3& other, const glm::dvec3& own) {
    const glm::dvec3 a = glm::max(other, glm::dvec3(1e-4));
    const glm::dvec3 b = glm::max(own, glm::dvec3(1e-4));
    result.ratios.push_back({slot, glm::log(a / b), std::log((a.r + a.g + a.b) / (b.r + b.g + b.b))});
  }

  const Camera& camera_;
  const Pyramid& photograph_;
  const Atlas& atlas_;
  std::span<const std::optional<ComparedView>> views_;
  std::optional<ViewSlot> except_;
  std::vector<bool> needed_;  // one per level
};

std::vector<ExposureRatio> median_ratios(const std::vector<PointColors>& points, std::size_t slots) {
  std::vector<std::array<std::vector<double>, 4>> logs(slots);
  for (const PointColors& point : points) {
    for (const PointColors::Ratio& ratio : point.ratios) {
      for (std::size_t channel = 0; channel < 3; ++channel) {
        logs[ratio.slot][channel].push_back(ratio.log_ratio[static_cast<int>(channel)]);
      }
      logs[ratio.slot][3].push_back(ratio.log_luminance);
    }
  }
  std::vector<ExposureRatio> ratios;
  for (ViewSlot slot{0}; slot < slots; ++slot) {
    auto& values = logs[slot];
    if (values[0].size() < kFewestRatioPoints) continue;
    const auto count = static_cast<std::uint32_t>(values[0].size());
    ratios.push_back(
        {slot, {median(values[0]), median(values[1]), median(values[2])}, glm::dvec3(median(values[3])), count});
  }
  return ratios;
}

}  // namespace

std::optional<glm::dvec3> seen_at(const ComparedView& view, const glm::dvec3& position) {
  const std::optional<Sighting> seen = sighting(view, position);
  if (!seen || !shows_well(*view.view, *seen)) return std::nullopt;
  return glm::dvec3(seen->at.image, seen->at.z);
}

std::optional<glm::dvec3> color_in_view(const ComparedView& other, const glm::dvec3& position, double pixel_size) {
  const std::optional<glm::dvec3> image = seen_at(other, position);
  if (!image) return std::nullopt;
  return other.pyramid.color(matching_level(other, image->z, pixel_size), glm::dvec2(*image));
}

MedianColors median_colors(const Camera& camera, const Pyramid& photograph, std::span<const SurfaceSample> samples,
                           const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                           std::optional<ViewSlot> except, const AlignmentOptions& alignment) {
  median_colors_requires.has_size(views.size(), atlas.capacity(), "views", "the atlas's capacity");
  median_colors_requires(photograph.level(0).width == camera.width, "camera.width", camera.width, "the photograph's");
  median_colors_requires(photograph.level(0).height == camera.height, "camera.height", camera.height,
                         "the photograph's");
  const std::size_t faces = atlas.surface()->cells.cell_of_face.size();
  for (const SurfaceSample& sample : samples)
    median_colors_requires.is_below(sample.face, faces, "a sample's face", "the faces");
  const ViewComparison comparison(camera, photograph, atlas, views, except, alignment);
  std::vector<PointColors> points(samples.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), 64),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) points[i] = comparison.at(samples[i]);
                    });
  MedianColors result;
  result.targets.colors.resize(photograph.levels());
  std::size_t observations = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (points[i].medians.empty()) continue;
    result.targets.positions.push_back(samples[i].position);
    for (std::uint32_t level = 0; level < photograph.levels(); ++level) {
      if (!needs_level(alignment, photograph, level)) continue;
      result.targets.colors[level].push_back(points[i].medians[level]);
    }
    observations += points[i].ratios.size();
  }
  const std::size_t kept = result.targets.positions.size();
  result.views_per_point = kept > 0 ? static_cast<double>(observations) / static_cast<double>(kept) : 0;
  result.ratios = median_ratios(points, views.size());
  return result;
}

}  // namespace lumatlas
