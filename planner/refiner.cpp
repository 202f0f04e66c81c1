// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refiner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "planner/surface_samples.h"

namespace lumatlas {

namespace {

void require(bool holds, const char* field, double value, const char* rule) {
  if (!holds) {
    throw std::invalid_argument("refinement: " + std::string(field) + " is " + std::to_string(value) + ", must be " +
                                rule);
  }
}

}  // namespace

void check(const RefinementOptions& options) {
  check(options.alignment);
  require(options.samples >= 1, "samples", static_cast<double>(options.samples), "at least 1");
  require(options.sample_px >= 1, "sample_px", options.sample_px, "at least 1");
  require(options.least_correlation >= -1 && options.least_correlation <= 1, "least_correlation",
          options.least_correlation, "in [-1, 1]");
  require(options.least_views >= 0, "least_views", options.least_views, "not negative");
}

Refiner::Refiner(Atlas& atlas, const Visibility& visibility, const RefinementOptions& options)
    : atlas_(atlas),
      visibility_(visibility),
      options_(options),
      views_(atlas.capacity()),
      given_(atlas.capacity()),
      exposures_(atlas.capacity()) {
  check(options);
}

Refinement Refiner::refine(const Camera& camera, const Photograph& photograph) const {
  return compare(camera, camera, Pyramid(photograph), std::nullopt);
}

Refinement Refiner::compare(const Camera& given, const Camera& start, const Pyramid& photograph,
                            std::optional<std::uint32_t> slot) const {
  const std::uint32_t sample_px = sampling_px(std::max(start.width, start.height), options_.sample_px);
  const VisibilityBuffer visible = visibility_.trace(start.shrunk_to(sample_px));
  const std::vector<SurfaceSample> samples = choose_surface_samples(start, photograph, visible, options_.samples);
  MedianColors others = median_colors(start, photograph, samples, atlas_, views_, slot);
  const glm::dvec3 gain = slot ? views_[*slot]->gain : glm::dvec3(1.0);
  Refinement result;
  result.alignment = align(given, start, gain, photograph, others.targets, options_.alignment);
  result.points = others.targets.positions.size();
  result.views_per_point = others.views_per_point;
  result.ratios = std::move(others.ratios);
  result.outlier = result.points >= kFewestAlignmentPoints && result.views_per_point >= options_.least_views &&
                   result.alignment.correlation < options_.least_correlation;
  return result;
}

void Refiner::stored(std::uint32_t slot, const Camera& given, const Refinement& refinement) {
  std::shared_ptr<const StoredView> view = atlas_.view(slot);
  const Photograph& photograph = view->photograph;
  views_[slot] = ComparedView{std::move(view), Pyramid(photograph), glm::dvec3(1.0)};
  given_[slot] = given;
  exposures_.set(slot, refinement.ratios);
  balance_exposures();
}

void Refiner::erased(std::uint32_t slot) {
  views_[slot].reset();
  exposures_.erase(slot);
}

void Refiner::balance_exposures() {
  if (!options_.alignment.exposure) return;
  const std::vector<glm::dvec3> gains = exposures_.solve(options_.alignment.white_balance);
  for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    views_[slot]->gain = gains[slot];
    atlas_.set_gain(slot, gains[slot]);
  }
}

void Refiner::replace(std::uint32_t slot, const Camera& camera, const ValidityOptions& validity) {
  const StoredView& old = *views_[slot]->view;
  atlas_.replace(slot, make_stored_view(old.name, camera, old.photograph, visibility_.trace(camera), validity, old.trust));
  views_[slot]->view = atlas_.view(slot);
  views_[slot]->pyramid.refer_to(views_[slot]->view->photograph);
}

PolishStep Refiner::polish(const ValidityOptions& validity) {
  std::vector<std::optional<Refinement>> refinements(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    const ComparedView& view = *views_[slot];
    refinements[slot] = compare(given_[slot], view.view->camera, view.pyramid, static_cast<std::uint32_t>(slot));
  });
  PolishStep step;
  double views = 0;
  for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
    if (!refinements[slot] || refinements[slot]->points < kFewestAlignmentPoints) continue;
    views += 1;
    step.residual_before += refinements[slot]->alignment.residual_given;
    step.residual_after += refinements[slot]->alignment.residual;
    step.moved_px += refinements[slot]->alignment.moved_px;
    exposures_.set(slot, refinements[slot]->ratios);
    if (refinements[slot]->alignment.moved) replace(slot, refinements[slot]->alignment.camera, validity);
  }
  if (views > 0) {
    step.residual_before /= views;
    step.residual_after /= views;
    step.moved_px /= views;
  }
  balance_exposures();
  return step;
}

}  // namespace lumatlas
