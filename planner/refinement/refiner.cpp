// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/refiner.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <utility>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "planner/coverage/nearby_sight.h"
#include "planner/refinement/photometry.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

namespace {

constexpr Requirement refiner_requires{"refinement"};

glm::dvec3 world_from_cam(const Camera& camera, const glm::dvec3& cam) {
  return glm::transpose(camera.cam_from_world_rotation) * (cam - camera.cam_from_world_translation);
}

// The rigid motion of the world that brings the given cameras nearest to the refined ones: what all have in common.
// Each camera stands for its centre and three points in front of it at the scene's depth.
struct RigidMotion {
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};
};
RigidMotion common_motion(const std::vector<std::pair<Camera, Camera>>& given_and_refined, double depth) {
  const auto count = static_cast<Eigen::Index>(given_and_refined.size());
  Eigen::Matrix3Xd from(3, 4 * count), to(3, 4 * count);
  const std::array<glm::dvec3, 4> points = {glm::dvec3(0), glm::dvec3(depth, 0, depth), glm::dvec3(0, depth, depth),
                                            glm::dvec3(-depth, -depth, depth)};
  Eigen::Index column = 0;
  for (const auto& [given, refined] : given_and_refined) {
    for (const glm::dvec3& point : points) {
      const glm::dvec3 a = world_from_cam(given, point);
      const glm::dvec3 b = world_from_cam(refined, point);
      from.col(column) << a.x, a.y, a.z;
      to.col(column++) << b.x, b.y, b.z;
    }
  }
  const Eigen::Matrix4d motion = Eigen::umeyama(from, to, false);
  RigidMotion result;
  for (int row = 0; row < 3; ++row) {
    for (int axis = 0; axis < 3; ++axis) result.rotation[axis][row] = motion(row, axis);
    result.translation[row] = motion(row, 3);
  }
  return result;
}

// The camera as if the world had been moved back.
Camera without(const RigidMotion& motion, const Camera& camera) {
  Camera still = camera;
  still.cam_from_world_rotation = camera.cam_from_world_rotation * motion.rotation;
  still.cam_from_world_translation =
      camera.cam_from_world_rotation * motion.translation + camera.cam_from_world_translation;
  return still;
}

// Returns by how many pixels, at most, points at `depth` before the camera move in the image when one camera takes the
// other's place. The image's corners and its middle stand for all.
double shift_px(const Camera& from, const Camera& to, double depth) {
  const double width = from.width, height = from.height;
  double most = 0;
  for (const glm::dvec2& image : {glm::dvec2(0, 0), glm::dvec2(width, 0), glm::dvec2(0, height),
                                  glm::dvec2(width, height), glm::dvec2(width / 2, height / 2)}) {
    const glm::dvec3 cam = to.cam_from_world(from.center() + depth * from.ray(image));
    if (!(cam.z > 0)) return std::numeric_limits<double>::infinity();
    most = std::max(most, glm::length(to.image_from_cam(cam) - image));
  }
  return most;
}

VisibilityBuffer visibility_of(const StoredView& view, std::span<const SeenFaces> runs) {
  return {view.camera.width, view.camera.height, view.mask->depth.all(), faces_of(runs)};
}

// One of kBriefShare. Samples come in pairs of a steep and a central one, mostly: now the one is taken, now the other.
std::vector<SurfaceSample> some_of(std::span<const SurfaceSample> samples) {
  std::vector<SurfaceSample> some;
  some.reserve(samples.size() / kBriefShare);
  for (std::size_t i = 0; i + 1 < samples.size(); i += kBriefShare) {
    some.push_back(samples[i + i / kBriefShare % 2]);
  }
  return some;
}

PolishStep summary_of(std::span<const std::optional<Refinement>> refinements) {
  PolishStep step;
  for (const std::optional<Refinement>& refinement : refinements) {
    if (!refinement || refinement->points < kFewestAlignmentPoints) continue;
    ++step.views;
    step.residual_before += refinement->alignment.residual_start;
    step.residual_after += refinement->alignment.residual;
    step.moved_px += refinement->alignment.moved_px;
  }
  if (step.views == 0) return step;
  step.residual_before /= step.views;
  step.residual_after /= step.views;
  step.moved_px /= step.views;
  return step;
}

}  // namespace

void check(const RefinementOptions& options) {
  check(options.alignment);
  check(options.trust);
  refiner_requires(options.samples >= 1, "samples", static_cast<double>(options.samples), "at least 1");
  refiner_requires(options.sample_px >= 1, "sample_px", options.sample_px, "at least 1");
  refiner_requires(options.polish_levels >= 1, "polish_levels", options.polish_levels, "at least 1");
  refiner_requires(options.least_correlation >= -1 && options.least_correlation <= 1, "least_correlation",
                   options.least_correlation, "in [-1, 1]");
  refiner_requires(options.least_views >= 0, "least_views", options.least_views, "not negative");
}

Refiner::Refiner(Atlas& atlas, const Visibility& visibility, const RefinementOptions& options,
                 const ValidityOptions& validity)
    : atlas_(atlas),
      visibility_(&visibility),
      options_(options),
      validity_(validity),
      views_(atlas.capacity()),
      samples_(atlas.capacity()),
      seen_(atlas.capacity()),
      given_(atlas.capacity()),
      neighbours_(atlas.capacity(), 0),
      masked_with_(atlas.capacity(), 0),
      visited_(atlas.capacity(), 0),
      exposures_(atlas.capacity()) {
  check(options);
}

Refinement Refiner::refine(const Camera& camera, const Photograph& photograph) const {
  check(camera);
  require_photograph_of("to be refined", camera, photograph);
  const auto prepared = std::make_shared<PreparedView>(PreparedView{Pyramid(photograph), camera, {}});
  prepared->samples = samples_of(camera, prepared->pyramid);
  Refinement result = may_be_brief() ? look_at(camera, prepared->pyramid, prepared->samples, std::nullopt)
                                     : compare(camera, camera, prepared->pyramid, prepared->samples, std::nullopt);
  result.prepared = prepared;
  return result;
}

// An improvement at few points is noisier and seems larger, because a fit to few points is closer. So a move that a
// full comparison would accept shows at least half of its improvement here.
bool Refiner::says_enough(const Refinement& brief) const {
  constexpr std::size_t kFewestPoints = 2 * kFewestAlignmentPoints;
  constexpr double kCorrelationMargin = 0.2;
  const Alignment& alignment = brief.alignment;
  if (brief.points < kFewestPoints || alignment.moved) return false;
  if (alignment.correlation && *alignment.correlation < options_.least_correlation + kCorrelationMargin) return false;
  return alignment.found_improvement < 0.5 * options_.alignment.least_improvement;
}

Refinement Refiner::look_at(const Camera& camera, const Pyramid& photograph, std::span<const SurfaceSample> samples,
                            std::optional<ViewSlot> slot) const {
  Refinement brief = compare(camera, camera, photograph, some_of(samples), slot);
  brief.brief = true;
  return says_enough(brief) ? brief : compare(camera, camera, photograph, samples, slot);
}

// The image in which points of a photograph are chosen.
Camera Refiner::sampling_camera(const Camera& camera) const {
  return camera.shrunk_to(sampling_px(std::max(camera.width, camera.height), options_.sample_px));
}

std::vector<SurfaceSample> Refiner::samples_of(const Camera& camera, const Pyramid& photograph) const {
  return choose_surface_samples(camera, photograph, near_sight(sampling_camera(camera)), options_.samples);
}

std::vector<SurfaceSample> Refiner::samples_of(ViewSlot slot) const {
  const ComparedView& view = *views_[slot];
  return choose_surface_samples(view.camera, view.pyramid, sight_of(slot, sampling_camera(view.camera)),
                                options_.samples);
}

// Returns what the stored view's camera sees at another size: from the view's depth if the faces that it shows are
// known, else by rays.
VisibilityBuffer Refiner::sight_of(ViewSlot slot, const Camera& camera) const {
  const StoredView& view = *views_[slot]->view;
  if (seen_[slot].empty()) return near_sight(camera);
  VisibilityBuffer visible = seen_nearby(view, FaceLookup(seen_[slot], view.camera.width, view.camera.height), camera);
  leave_out_far(*atlas_.surface(), visible);
  return visible;
}

// Returns what a camera sees of the surface without the far sphere. Photographs are not compared on the far sphere,
// because clouds move, and a near surface that the mesh lacks is at another point of it in each photograph.
VisibilityBuffer Refiner::near_sight(const Camera& camera) const {
  VisibilityBuffer visible = visibility_->trace(camera);
  leave_out_far(*atlas_.surface(), visible);
  return visible;
}

Refinement Refiner::compare(const Camera& given, const Camera& start, const Pyramid& photograph,
                            std::span<const SurfaceSample> samples, std::optional<ViewSlot> slot) const {
  check_cancelled(options_.cancel_check);
  AlignmentOptions alignment = options_.alignment;
  if (slot) {
    alignment.levels = options_.polish_levels;
    alignment.correlation = false;  // it says who is an outlier, and who is stored is none
  }
  MedianColors others = median_colors(start, photograph, samples, atlas_, views_, slot, alignment);
  const glm::dvec3 gain = slot ? views_[*slot]->gain : glm::dvec3(1.0);
  Refinement result;
  result.alignment = align(given, start, gain, photograph, others.targets, alignment);
  result.points = others.targets.positions.size();
  result.views_per_point = others.views_per_point;
  result.ratios = std::move(others.ratios);
  result.outlier = result.points >= kFewestAlignmentPoints && result.views_per_point >= options_.least_views &&
                   result.alignment.correlation && *result.alignment.correlation < options_.least_correlation;
  return result;
}

void Refiner::add(ViewSlot slot, const Camera& given, const Refinement& refinement, std::span<const FaceId> face) {
  refiner_requires.is_below(slot, views_.size(), "slot", "the atlas's capacity");
  check(given);
  std::shared_ptr<const StoredView> view = atlas_.view(slot);
  refiner_requires(view != nullptr, "slot", slot, "one that holds a view");
  for (const ExposureRatio& ratio : refinement.ratios) {
    refiner_requires.is_below(ratio.slot, views_.size(), "a ratio's slot", "the atlas's capacity");
  }
  if (!face.empty())
    refiner_requires.has_size(face.size(), view->mask->depth.size(), "face", "the number of the view's pixels");
  const PhotographSpan photograph = view->photograph->span();
  samples_[slot].reset();
  if (refinement.prepared) {
    const PreparedView& prepared = *refinement.prepared;
    Pyramid pyramid = prepared.pyramid;
    pyramid.refer_to(photograph);
    if (same_pose(prepared.camera, view->camera)) samples_[slot] = ChosenSamples{prepared.camera, prepared.samples};
    views_[slot] = ComparedView{view, view->camera, std::move(pyramid), glm::dvec3(1.0)};
  } else {
    views_[slot] = ComparedView{view, view->camera, Pyramid(photograph), glm::dvec3(1.0)};
  }
  seen_[slot] = seen_faces(face, atlas_.surface()->cells.cell_of_face);
  given_[slot] = given;
  // The views that left for this one were compared with it too.
  std::vector<ExposureRatio> ratios = refinement.ratios;
  std::erase_if(ratios, [&](const ExposureRatio& ratio) { return ratio.slot == slot || !views_[ratio.slot]; });
  exposures_.set(slot, ratios);
  // Its neighbours are compared with it next, so it needs its gain before.
  balance_exposures();
  visited_[slot] = ++visits_;
  count_comparison(refinement);
  if (revisit(slot)) balance_exposures();
  if (!options_.trust.enabled) return;
  neighbours_[slot] = static_cast<std::uint32_t>(ratios.size());
  mask(slot, TrustExtent::blocks);
  // Its neighbours can be judged better now. Doing so whenever they have twice as many costs each view a logarithm.
  for (const ExposureRatio& ratio : ratios) {
    if (++neighbours_[ratio.slot] >= 2 * std::max(1u, masked_with_[ratio.slot])) mask(ratio.slot, TrustExtent::blocks);
  }
}

Camera Refiner::refined_from(ViewSlot slot, const Camera& given) const {
  refiner_requires.is_below(slot, views_.size(), "slot", "the atlas's capacity");
  if (!views_[slot]) return given;
  const Camera &before = given_[slot], &refined = views_[slot]->camera;
  const glm::dmat3 turn = refined.cam_from_world_rotation * glm::transpose(before.cam_from_world_rotation);
  const glm::dvec3 shift = refined.cam_from_world_translation - turn * before.cam_from_world_translation;
  Camera result = refined;
  result.cam_from_world_rotation = turn * given.cam_from_world_rotation;
  result.cam_from_world_translation = turn * given.cam_from_world_translation + shift;
  return result;
}

void Refiner::set_pose(ViewSlot slot, const Camera& given, const Camera& refined) {
  refiner_requires.is_below(slot, views_.size(), "slot", "the atlas's capacity");
  if (!views_[slot]) return;
  given_[slot] = given;
  views_[slot]->camera = refined;
  samples_[slot].reset();
  still_ = 0;
  refresh(slot);
}

void Refiner::set_visibility(const Visibility& visibility) {
  visibility_ = &visibility;
  for (std::optional<ChosenSamples>& chosen : samples_) chosen.reset();
  for (std::vector<SeenFaces>& runs : seen_) runs.clear();
}

void Refiner::remove(ViewSlot slot) {
  refiner_requires.is_below(slot, views_.size(), "slot", "the atlas's capacity");
  views_[slot].reset();
  samples_[slot].reset();
  seen_[slot].clear();
  neighbours_[slot] = masked_with_[slot] = 0;
  exposures_.erase(slot);
}

void Refiner::balance_exposures() {
  if (!options_.alignment.exposure) return;
  const auto& given = options_.given_gain;
  const std::vector<glm::dvec3> gains =
      given ? std::vector<glm::dvec3>() : exposures_.solve(options_.alignment.white_balance);
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    views_[slot]->gain = given ? given(views_[slot]->view->name) : gains[slot];
    atlas_.set_gain(slot, views_[slot]->gain);
  }
}

void Refiner::replace(ViewSlot slot, const Camera& camera, std::shared_ptr<const StoredPhotograph> photograph,
                      std::vector<std::uint8_t> trust) {
  const StoredView& old = *views_[slot]->view;
  const bool sees_the_same = !seen_[slot].empty() && same_pose(camera, old.camera);
  VisibilityBuffer visible = sees_the_same ? visibility_of(old, seen_[slot]) : visibility_->trace_sparsely(camera);
  std::vector<SeenFaces> seen = seen_faces(visible.face, atlas_.surface()->cells.cell_of_face);
  TiledView tiled = make_tiled_view(old.name, camera, std::move(photograph), std::move(visible),
                                    atlas_.surface()->cells, atlas_.layout(), validity_, std::move(trust));
  atlas_.replace(slot, std::move(tiled.view), std::move(tiled.shown));
  refresh(slot);
  seen_[slot] = std::move(seen);
}

// Keeps the camera as it is believed to be now.
void Refiner::replace(ViewSlot slot, std::vector<std::uint8_t> trust) {
  replace(slot, views_[slot]->camera, views_[slot]->view->photograph, std::move(trust));
}

// See kDepthStandsPx.
bool Refiner::depth_stands(ViewSlot slot) const {
  const StoredView& view = *views_[slot]->view;
  const auto depth = static_cast<double>(lumatlas::median_depth(view, depth_before_far(*atlas_.surface())));
  return shift_px(view.camera, views_[slot]->camera, depth) < kDepthStandsPx;
}

void Refiner::move(ViewSlot slot, const Camera& camera) {
  views_[slot]->camera = camera;
  if (!depth_stands(slot)) replace(slot, views_[slot]->view->mask->trust.all());
}

void Refiner::refresh(ViewSlot slot) {
  refiner_requires.is_below(slot, views_.size(), "slot", "the atlas's capacity");
  if (!views_[slot]) return;
  const StoredPhotograph &before = *views_[slot]->view->photograph, &now = *atlas_.view(slot)->photograph;
  if (before.width() != now.width() || before.height() != now.height()) {
    remove(slot);
    return;
  }
  views_[slot]->view = atlas_.view(slot);
  views_[slot]->pyramid.refer_to(views_[slot]->view->photograph->span());
  seen_[slot].clear();
}

void Refiner::mask(ViewSlot slot, TrustExtent extent) {
  check_cancelled(options_.cancel_check);
  const ComparedView& view = *views_[slot];
  const Camera& camera = view.camera;
  masked_with_[slot] = neighbours_[slot];
  std::vector<std::uint8_t> trust =
      trust_mask(camera, view.pyramid, view.gain, sight_of(slot, camera.shrunk_to(options_.trust.grid_px)), atlas_,
                 views_, slot, options_.trust, extent);
  if (!(view.view->mask->trust == trust)) replace(slot, std::move(trust));
}

void Refiner::publish_refined() {
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    check_cancelled(options_.cancel_check);
    if (options_.trust.enabled) mask(slot, TrustExtent::regions);
    const ComparedView& view = *views_[slot];
    if (!same_pose(view.camera, view.view->camera)) replace(slot, view.view->mask->trust.all());
  }
}

// The median depth of the surface that the stored views see, from every 997th pixel of each.
double Refiner::median_depth() const {
  constexpr std::size_t kStride = 997;
  const float below = depth_before_far(*atlas_.surface());
  std::vector<float> depths;
  for (const std::optional<ComparedView>& view : views_) {
    if (!view) continue;
    for (std::size_t pixel = 0; pixel < view->view->mask->depth.size(); pixel += kStride) {
      if (view->view->mask->depth[pixel] < below) depths.push_back(view->view->mask->depth[pixel]);
    }
  }
  if (depths.empty()) return 1;
  return static_cast<double>(upper_median(depths));
}

// A view that has not moved since last time is compared at the same points.
void Refiner::choose_samples(ViewSlot slot) {
  const ComparedView& view = *views_[slot];
  const Camera& camera = view.camera;
  if (samples_[slot] && same_pose(samples_[slot]->camera, camera)) return;
  samples_[slot] = ChosenSamples{camera, samples_of(slot)};
}

Refinement Refiner::compare_again(ViewSlot slot) {
  choose_samples(slot);
  const ComparedView& view = *views_[slot];
  return compare(given_[slot], view.camera, view.pyramid, samples_[slot]->samples, slot);
}

// A comparison with too few points says nothing about poses.
void Refiner::count_comparison(const Refinement& refinement) {
  compared_in_full_ += !refinement.brief;
  if (refinement.points < kFewestAlignmentPoints) return;
  still_ = refinement.alignment.moved ? 0 : still_ + 1;
}

// Returns whether exposures were compared anew.
bool Refiner::revisit(ViewSlot newest) {
  bool compared = false;
  for (std::uint32_t i = 0; i < options_.revisits && !at_rest(); ++i) {
    std::optional<ViewSlot> next;
    for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
      if (views_[slot] && slot != newest && (!next || visited_[slot] < visited_[*next])) next = slot;
    }
    if (!next) return compared;
    visited_[*next] = ++visits_;
    const Refinement refinement = compare_again(*next);
    ++revisited_;
    count_comparison(refinement);
    if (refinement.points < kFewestAlignmentPoints) continue;
    exposures_.set(*next, refinement.ratios);
    compared = true;
    if (refinement.alignment.moved) move(*next, refinement.alignment.camera);
  }
  return compared;
}

// Returns the samples of every stored view, by slot.
std::vector<std::vector<SurfaceSample>> Refiner::all_samples() const {
  std::vector<std::vector<SurfaceSample>> samples(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(options_.cancel_check);
    const Camera& camera = views_[slot]->camera;
    const bool chosen = samples_[slot] && same_pose(samples_[slot]->camera, camera);
    samples[slot] = chosen ? samples_[slot]->samples : samples_of(ViewSlot(static_cast<std::uint32_t>(slot)));
  });
  return samples;
}

PoseEstimate Refiner::solve_poses(std::size_t most_points) {
  if (!options_.alignment.pose) return {};
  PoseEstimate estimate = estimate_poses(
      atlas_, views_, given_, all_samples(),
      {.alignment = options_.alignment, .most_points = most_points, .cancel_check = options_.cancel_check});
  if (!estimate.improves()) return estimate;
  std::vector<std::pair<Camera, Camera>> given_and_refined;
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (views_[slot]) given_and_refined.emplace_back(given_[slot], estimate.cameras[slot]);
  }
  const double depth = median_depth();
  const RigidMotion common = common_motion(given_and_refined, depth);
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    check_cancelled(options_.cancel_check);
    const Camera camera = without(common, estimate.cameras[slot]);
    const double most_px = options_.alignment.max_move * std::max(camera.width, camera.height);
    if (shift_px(views_[slot]->camera, camera, depth) < options_.alignment.least_move_px) continue;
    if (shift_px(given_[slot], camera, depth) <= most_px) move(slot, camera);
  }
  return estimate;
}

LensEstimates Refiner::estimate_lenses(const LensOptions& options) const {
  LensOptions interruptible = options;
  if (!interruptible.cancel_check) interruptible.cancel_check = options_.cancel_check;
  interruptible.alignment = options_.alignment;
  return lumatlas::estimate_lenses(atlas_, views_, given_, all_samples(), interruptible);
}

ShutterEstimate Refiner::estimate_shutters(const ShutterOptions& options) const {
  ShutterOptions interruptible = options;
  if (!interruptible.cancel_check) interruptible.cancel_check = options_.cancel_check;
  interruptible.alignment = options_.alignment;
  return lumatlas::estimate_shutters(atlas_, views_, given_, all_samples(), interruptible);
}

// Gives views the cameras of an estimate, and photographs that `corrected` makes. What they have moved as a whole is
// taken back.
void Refiner::correct(std::span<const ViewSlot> slots, const std::vector<Camera>& cameras,
                      const CorrectedPhotograph& corrected) {
  std::vector<std::pair<Camera, Camera>> before_and_after;
  for (const ViewSlot slot : slots) before_and_after.emplace_back(views_[slot]->camera, cameras[slot]);
  const RigidMotion common = common_motion(before_and_after, median_depth());
  for (const ViewSlot slot : slots) {
    check_cancelled(options_.cancel_check);
    const std::shared_ptr<const StoredView> old = views_[slot]->view;
    Photograph photograph = corrected(slot, old->name);
    require_photograph_of(old->name, old->camera, photograph);
    views_[slot]->camera = without(common, cameras[slot]);
    const Camera& camera = depth_stands(slot) ? old->camera : views_[slot]->camera;
    replace(slot, camera, std::make_shared<const StoredPhotograph>(std::move(photograph)), old->mask->trust.all());
    views_[slot]->pyramid = Pyramid(views_[slot]->view->photograph->span());
    samples_[slot].reset();
  }
}

void Refiner::correct_lenses(const LensEstimates& estimates, const CorrectedPhotograph& corrected) {
  refiner_requires.has_size(estimates.cameras.size(), views_.size(), "cameras", "the atlas's capacity");
  std::vector<ViewSlot> slots;
  for (const LensEstimate& lens : estimates.lenses) {
    for (const ViewSlot slot : lens.slots) {
      refiner_requires.is_below(slot, views_.size(), "a lens's slot", "the atlas's capacity");
      refiner_requires(views_[slot].has_value(), "a lens's slot", slot, "one that holds a view");
      check(estimates.cameras[slot]);
      require_photograph_of(views_[slot]->view->name, estimates.cameras[slot], *views_[slot]->view->photograph);
      if (lens.significant) slots.push_back(slot);
    }
  }
  if (!slots.empty()) correct(slots, estimates.cameras, corrected);
}

void Refiner::correct_shutters(const ShutterEstimate& estimate, const CorrectedPhotograph& corrected) {
  refiner_requires.has_size(estimate.cameras.size(), views_.size(), "cameras", "the atlas's capacity");
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!views_[slot]) continue;
    check(estimate.cameras[slot]);
    require_photograph_of(views_[slot]->view->name, estimate.cameras[slot], *views_[slot]->view->photograph);
    slots.push_back(slot);
  }
  if (estimate.significant && !slots.empty()) correct(slots, estimate.cameras, corrected);
}

bool Refiner::all_as_given() const {
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (views_[slot] && !same_pose(views_[slot]->camera, given_[slot])) return false;
  }
  return true;
}

// Compares the exposures of all stored views with the others at all of their points, and balances them.
void Refiner::compare_exposures() {
  AlignmentOptions ratios_alone = options_.alignment;
  ratios_alone.levels = 1;
  ratios_alone.correlation = false;
  std::vector<std::vector<ExposureRatio>> ratios(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(options_.cancel_check);
    ratios[slot] = median_colors(views_[slot]->camera, views_[slot]->pyramid, samples_[slot]->samples, atlas_, views_,
                                 ViewSlot(static_cast<std::uint32_t>(slot)), ratios_alone)
                       .ratios;
  });
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (views_[slot]) exposures_.set(slot, ratios[slot]);
  }
  balance_exposures();
}

// The step, if a look at all views finds that each belongs where it was given.
std::optional<PolishStep> Refiner::found_in_place() {
  std::vector<std::optional<Refinement>> refinements(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(options_.cancel_check);
    const ViewSlot self(static_cast<std::uint32_t>(slot));
    choose_samples(self);
    refinements[slot] = look_at(given_[slot], views_[slot]->pyramid, samples_[slot]->samples, self);
  });
  for (const std::optional<Refinement>& refinement : refinements) {
    if (!refinement) continue;
    compared_in_full_ += !refinement->brief;
    if (refinement->alignment.moved) return std::nullopt;
  }
  compare_exposures();
  return summary_of(refinements);
}

PolishStep Refiner::polish() {
  if (may_be_brief() && all_as_given()) {
    if (const std::optional<PolishStep> step = found_in_place()) return *step;
  }
  std::vector<std::optional<Refinement>> refinements(views_.size());
  tbb::parallel_for(std::size_t{0}, views_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(options_.cancel_check);
    refinements[slot] = compare_again(ViewSlot(static_cast<std::uint32_t>(slot)));
  });
  for (const std::optional<Refinement>& refinement : refinements) compared_in_full_ += refinement.has_value();
  const PolishStep step = summary_of(refinements);
  if (step.views == 0) return step;
  // Nothing but the given poses ties the set as a whole to the mesh, so as a whole it stays where they put it.
  std::vector<std::pair<Camera, Camera>> given_and_refined;
  bool corrected = false;
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!refinements[slot]) continue;
    given_and_refined.emplace_back(given_[slot], refinements[slot]->alignment.camera);
    corrected = corrected || refinements[slot]->alignment.corrected;
  }
  const double depth = median_depth();
  const RigidMotion common = corrected ? common_motion(given_and_refined, depth) : RigidMotion{};
  for (ViewSlot slot{0}; slot < views_.size(); ++slot) {
    if (!refinements[slot]) continue;
    check_cancelled(options_.cancel_check);
    exposures_.set(slot, refinements[slot]->ratios);
    const Camera camera = without(common, refinements[slot]->alignment.camera);
    // A view that stays where it is keeps its depth and mask.
    const Camera& before = views_[slot]->camera;
    if (same_pose(before, camera) || shift_px(before, camera, depth) < options_.alignment.least_move_px) continue;
    move(slot, camera);
  }
  balance_exposures();
  return step;
}

}  // namespace lumatlas
