// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/diagnosis/view_flow.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <memory>
#include <optional>
#include <utility>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr double kSeenDepth = 0.01;   // share of a point's depth by which another view's depth may differ
constexpr double kPatchDepth = 0.1;   // share of its middle's depth by which the depth of a patch may differ
constexpr std::uint8_t kValid = 128;  // least validity of a pixel that is compared
constexpr double kDirection = 0.8;    // weight of the direction in the choice of the second view: lambda, section 3.1
constexpr double kNearer = 0.999;     // depth of the point that tells which way the epipolar line goes

// A view and what is needed to compare it.
struct ComparedPhotograph {
  const StoredView* view;
  Photograph pixels;
  std::optional<Pyramid> pyramid;
  glm::dvec3 center;

  ComparedPhotograph(const StoredView& stored, std::uint32_t levels)
      : view(&stored), pixels(stored.photograph->whole()), center(stored.camera.center()) {
    const std::uint32_t longer = std::max(pixels.width, pixels.height);
    pyramid.emplace(PhotographSpan(pixels), std::max(longer >> levels, 1U));
  }
};

// Returns the depth at a pixel that may be compared; none elsewhere.
std::optional<double> depth_at(const StoredView& view, const glm::dvec2& image) {
  const Camera& camera = view.camera;
  if (!(image.x >= 0 && image.y >= 0 && image.x < camera.width && image.y < camera.height)) return std::nullopt;
  const std::size_t pixel = static_cast<std::size_t>(image.y) * camera.width + static_cast<std::size_t>(image.x);
  const float depth = view.mask->depth[pixel];
  if (view.mask->validity[pixel] < kValid || view.mask->at_rim(pixel) || !std::isfinite(depth)) return std::nullopt;
  return depth;
}

// Returns where a view shows a point of the surface; none where something hides it.
std::optional<glm::dvec2> image_of(const StoredView& view, const glm::dvec3& point) {
  const glm::dvec3 cam = view.camera.cam_from_world(point);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  const std::optional<double> depth = depth_at(view, image);
  if (!depth || std::abs(*depth - cam.z) > kSeenDepth * cam.z) return std::nullopt;
  return image;
}

class FlowFinder {
 public:
  FlowFinder(const Snapshot& snapshot, const ViewFlowOptions& options) : options_(options) {
    photographs_.resize(snapshot.views.size());
    tbb::parallel_for(std::size_t{0}, photographs_.size(), [&](std::size_t slot) {
      check_cancelled(options.cancel_check);
      const auto& view = snapshot.views[slot];
      if (view) photographs_[slot] = std::make_unique<ComparedPhotograph>(*view, options.patch.levels);
    });
  }

  [[nodiscard]] ViewFlow find() const {
    std::vector<ViewFlow> each(photographs_.size());
    tbb::parallel_for(std::size_t{0}, each.size(), [&](std::size_t slot) {
      check_cancelled(options_.cancel_check);
      if (photographs_[slot]) each[slot] = flows_of(slot);
    });
    ViewFlow result;
    for (const ViewFlow& one : each) {
      result.shown += one.shown;
      result.shown_by_view.push_back(one.shown);
      result.flows.insert(result.flows.end(), one.flows.begin(), one.flows.end());
    }
    return result;
  }

 private:
  [[nodiscard]] ViewFlow flows_of(std::size_t slot) const {
    const Camera& camera = photographs_[slot]->view->camera;
    const double pixels = double{1} * camera.width * camera.height;
    const double area = pixels / options_.patches_per_view;
    const double step = std::max(std::sqrt(area), 1.0);
    ViewFlow result;
    const auto rows = static_cast<std::size_t>(std::ceil(camera.height / step));
    const auto columns = static_cast<std::size_t>(std::ceil(camera.width / step));
    for (std::size_t i = 0; i < rows * columns; ++i) {
      const std::size_t column = i % columns, row = i / columns;
      add_patch(slot, step * (glm::dvec2(column, row) + 0.5), result);
    }
    return result;
  }

  void add_patch(std::size_t slot, const glm::dvec2& image, ViewFlow& result) const {
    const ComparedPhotograph& first = *photographs_[slot];
    const Camera& camera = first.view->camera;
    const std::optional<double> depth = depth_at(*first.view, image);
    if (!depth) return;
    const glm::dvec3 ray = camera.ray(image);
    const glm::dvec3 point = first.center + *depth * ray;
    const std::optional<std::size_t> other = best_other(slot, point);
    if (!other) return;
    ++result.shown;
    const ComparedPhotograph& second = *photographs_[*other];
    const auto carried = [&](const glm::dvec2& at) -> std::optional<glm::dvec2> {
      const std::optional<double> own = depth_at(*first.view, at);
      if (!own || std::abs(*own - *depth) > kPatchDepth * *depth) return std::nullopt;
      return image_of(*second.view, first.center + *own * camera.ray(at));
    };
    const std::optional<glm::dvec2> flow = patch_flow(*first.pyramid, *second.pyramid, image, carried, options_.patch);
    if (!flow) return;
    const Camera& seen_by = second.view->camera;
    const glm::dvec2 nearer = seen_by.image_from_cam(seen_by.cam_from_world(first.center + kNearer * *depth * ray));
    const glm::dvec2 line = glm::normalize(nearer - seen_by.image_from_cam(seen_by.cam_from_world(point)));
    const glm::dvec2 beside(-line.y, line.x);
    result.flows.push_back({ViewSlot(static_cast<std::uint32_t>(slot)), ViewSlot(static_cast<std::uint32_t>(*other)),
                            image, *flow, glm::dot(*flow, line), glm::dot(*flow, beside)});
  }

  // Returns the view of largest weight for a point in a picture from the first one's camera.
  [[nodiscard]] std::optional<std::size_t> best_other(std::size_t first, const glm::dvec3& point) const {
    const glm::dvec3 to_first = photographs_[first]->center - point;
    const double distance = glm::length(to_first);
    const double most_cosine = std::cos(glm::radians(options_.least_angle_deg));
    std::optional<std::size_t> best;
    double largest = 0;
    for (std::size_t slot = 0; slot < photographs_.size(); ++slot) {
      if (slot == first || !photographs_[slot]) continue;
      const glm::dvec3 to_other = photographs_[slot]->center - point;
      const double other_distance = glm::length(to_other);
      const double cosine = glm::dot(to_first, to_other) / (distance * other_distance);
      const double weight = kDirection * std::max(cosine, 0.0) +
                            (1 - kDirection) * std::min(distance, other_distance) / std::max(distance, other_distance);
      if (!(weight > largest) || cosine > most_cosine || !image_of(*photographs_[slot]->view, point)) continue;
      largest = weight;
      best = slot;
    }
    return best;
  }

  const ViewFlowOptions& options_;
  std::vector<std::unique_ptr<ComparedPhotograph>> photographs_;  // by view slot; null: the slot is free
};

constexpr Requirement view_flow_requires{"flow"};

}  // namespace

void check(const ViewFlowOptions& options) {
  view_flow_requires(options.patches_per_view >= 1, "patches_per_view", options.patches_per_view, "at least 1");
  view_flow_requires(options.least_angle_deg > 0 && options.least_angle_deg < 90, "least_angle_deg",
                     options.least_angle_deg, "in (0, 90)");
  check(options.patch);
}

ViewFlow view_flow(const Snapshot& snapshot, const ViewFlowOptions& options) {
  check(options);
  check(snapshot);
  return FlowFinder(snapshot, options).find();
}

}  // namespace lumatlas
