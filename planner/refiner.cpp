// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refiner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <glm/matrix.hpp>
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

// The given pose moves as the refined one does, and takes its intrinsics: what was learnt since is what pulls.
Camera moved_along(const Camera& given, const Camera& from, const Camera& to) {
  Camera result = to;
  const glm::dmat3 turn = to.cam_from_world_rotation * glm::transpose(from.cam_from_world_rotation);
  const glm::dvec3 shift = to.cam_from_world_translation - turn * from.cam_from_world_translation;
  result.cam_from_world_rotation = turn * given.cam_from_world_rotation;
  result.cam_from_world_translation = turn * given.cam_from_world_translation + shift;
  return result;
}

}  // namespace

void check(const RefinementOptions& options) {
  check(options.alignment);
  check(options.trust);
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
      neighbours_(atlas.capacity(), 0),
      masked_with_(atlas.capacity(), 0),
      exposures_(atlas.capacity()) {
  check(options);
}

Refinement Refiner::refine(const Camera& camera, const Photograph& photograph) const {
  return compare(camera, camera, Pyramid(photograph), std::nullopt);
}

std::vector<SurfaceSample> Refiner::samples_of(const Camera& camera, const Pyramid& photograph) const {
  const VisibilityBuffer visible = visibility_.trace(camera.shrunk_to(options_.sample_px));
  return choose_surface_samples(camera, photograph, visible, options_.samples);
}

Refinement Refiner::compare(const Camera& given, const Camera& start, const Pyramid& photograph,
                            std::optional<std::uint32_t> slot) const {
  MedianColors others = median_colors(start, photograph, samples_of(start, photograph), atlas_, views_, slot);
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

void Refiner::stored(std::uint32_t slot, const Camera& given, const Refinement& refinement,
                     const ValidityOptions& validity) {
  std::shared_ptr<const StoredView> view = atlas_.view(slot);
  const Photograph& photograph = view->photograph;
  views_[slot] = ComparedView{std::move(view), Pyramid(photograph), glm::dvec3(1.0)};
  given_[slot] = given;
  exposures_.set(slot, refinement.ratios);
  balance_exposures();
  if (!options_.trust.enabled) return;
  neighbours_[slot] = static_cast<std::uint32_t>(refinement.ratios.size());
  mask(slot, validity);
  // Its neighbours can be judged better now. Doing so whenever they have twice as many costs each view a logarithm.
  for (const ExposureRatio& ratio : refinement.ratios) {
    if (++neighbours_[ratio.slot] >= 2 * std::max(1u, masked_with_[ratio.slot])) mask(ratio.slot, validity);
  }
}

void Refiner::erased(std::uint32_t slot) {
  views_[slot].reset();
  neighbours_[slot] = masked_with_[slot] = 0;
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

void Refiner::replace(std::uint32_t slot, const Camera& camera, std::vector<std::uint8_t> trust,
                      const ValidityOptions& validity) {
  const StoredView& old = *views_[slot]->view;
  atlas_.replace(
      slot, make_stored_view(old.name, camera, old.photograph, visibility_.trace(camera), validity, std::move(trust)));
  views_[slot]->view = atlas_.view(slot);
  views_[slot]->pyramid.refer_to(views_[slot]->view->photograph);
}

void Refiner::mask(std::uint32_t slot, const ValidityOptions& validity) {
  const ComparedView& view = *views_[slot];
  const Camera& camera = view.view->camera;
  masked_with_[slot] = neighbours_[slot];
  std::vector<std::uint8_t> trust =
      trust_mask(camera, view.pyramid, view.gain, visibility_.trace(camera.shrunk_to(options_.trust.grid_px)), atlas_,
                 views_, slot, options_.trust);
  if (trust != view.view->trust) replace(slot, camera, std::move(trust), validity);
}

void Refiner::mask(const ValidityOptions& validity) {
  for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
    if (views_[slot]) mask(slot, validity);
  }
}

IntrinsicsEstimate Refiner::estimate_intrinsics(const IntrinsicsOptions& options) const {
  std::vector<std::vector<SurfaceSample>> samples(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (views_[slot]) samples[slot] = samples_of(views_[slot]->view->camera, views_[slot]->pyramid);
  });
  return lumatlas::estimate_intrinsics(atlas_, views_, samples, options);
}

void Refiner::set_cameras(const IntrinsicsEstimate& estimate, const ValidityOptions& validity) {
  for (std::uint32_t slot = 0; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    const Camera& camera = estimate.cameras[slot];
    given_[slot] = moved_along(given_[slot], views_[slot]->view->camera, camera);
    replace(slot, camera, views_[slot]->view->trust, validity);
  }
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
    if (refinements[slot]->alignment.moved)
      replace(slot, refinements[slot]->alignment.camera, views_[slot]->view->trust, validity);
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
