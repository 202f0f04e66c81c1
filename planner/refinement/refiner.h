// SPDX-License-Identifier: GPL-3.0-or-later
// View processing, Erat et al. 2019, section 3.3: makes each view that is about to be stored agree with the stored ones
// in exposure and pose, and finds the views that do not belong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/cancel_check.h"
#include "mesh/visibility/visibility.h"
#include "planner/coverage/seen_faces.h"
#include "planner/refinement/alignment.h"
#include "planner/refinement/exposure_graph.h"
#include "planner/refinement/lens_estimate.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/pose_estimate.h"
#include "planner/refinement/shutter_estimate.h"
#include "planner/refinement/trust/trust.h"

namespace lumatlas {

// After this many comparisons in a row that moved no view, views rest until one moves. While they rest, stored views
// are not refined again, and a view is compared in brief first, at a share of its points. It is compared in full only
// if the brief look finds half of the improvement for which a pose is accepted, or something near an outlier.
inline constexpr std::uint32_t kComparisonsToRest = 16;
inline constexpr std::size_t kBriefShare = 4;  // a brief look takes every fourth point

// A refined pose of a stored view is used for comparisons at once. It is published in the atlas, with a depth of its
// own, only if it moves the image by at least this many pixels, or by publish_refined(), because making depth is most
// of the cost of moving a view. Until then visibility is looked up with the pose that the depth was made with.
inline constexpr double kDepthStandsPx = 2;

struct RefinementOptions {
  TrustOptions trust;
  AlignmentOptions alignment;     // its pose, exposure and white_balance say what is refined
  std::size_t samples = 2000;     // surface points at which views are compared, >= 1
  std::uint32_t sample_px = 320;  // longer side of the image that they are chosen in, >= 1
  // After each view that is stored, this many stored ones are refined again, those first whose turn was longest ago, so
  // that they learn from the views that came after them; none while views rest, see kComparisonsToRest.
  std::uint32_t revisits = 2;
  std::uint32_t polish_levels = 3;  // of the pyramid, >= 1: a stored view is nearly right
  // A view whose correlation with the others' medians stays below this is an outlier, [-1, 1].
  double least_correlation = 0.5;
  double least_views = 1;  // but only where that many other views, in the mean, show each of its points
  // Called by polish(), solve_poses(), publish_refined(), estimate_lenses(), correct_lenses(), the same for shutters,
  // and Pruning between one view and the next. If it throws, some views may have been changed and others not; each is
  // as consistent as before.
  CancelCheck cancel_check = {};
  // Returns the gain of the view of that name, which it then keeps: exposures that were balanced elsewhere, for example
  // over all blocks of a city. Empty: stored views are balanced among each other.
  std::function<glm::dvec3(const std::string& name)> given_gain = {};

  [[nodiscard]] bool any() const { return alignment.pose || alignment.exposure; }
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const RefinementOptions& options);

// Data that comparing a photograph needs, and that add() need not make again.
struct PreparedView {
  Pyramid pyramid;  // whose level 0 may be gone
  Camera camera;    // that the samples were chosen with
  std::vector<SurfaceSample> samples;
};

struct Refinement {
  Alignment alignment;
  std::size_t points = 0;      // that other views show too
  double views_per_point = 0;  // how many of them, in the mean
  bool outlier = false;
  bool brief = false;  // `points` and what follows from them are of a brief look
  std::vector<ExposureRatio> ratios;
  std::shared_ptr<const PreparedView> prepared;  // of the photograph; none: add() makes it
};

// Means over the stored views that have points in common with others.
struct PolishStep {
  std::uint32_t views = 0;  // how many these are; 0: nothing was compared, and nothing was changed
  // Alignment::residual of the poses that the views had before the step, and of those that it found, against the same
  // colours of the other views.
  double residual_before = 0, residual_after = 0;
  // Distance of the views from their given poses, before the set as a whole is moved back; 0: all views have their
  // given poses.
  double moved_px = 0;
};

// Gives the photograph of a stored view, by slot and name, as the corrected lens, or a camera that did not move, would
// have taken it.
using CorrectedPhotograph = std::function<Photograph(ViewSlot slot, const std::string& name)>;

// Slots that the atlas does not have, or that hold no view where one is needed, are refused (std::invalid_argument).
class Refiner {
 public:
  // Atlas and visibility must outlive the refiner. Its caller calls add(), refresh(), set_pose() and remove() for each
  // change of the atlas's views. `validity` says how the depth edges of views that move are masked.
  Refiner(Atlas& atlas, const Visibility& visibility, const RefinementOptions& options,
          const ValidityOptions& validity = {});

  // Compares the photograph, which must be as large as its camera says (require_photograph_of(),
  // std::invalid_argument), with the stored views. Changes nothing.
  [[nodiscard]] Refinement refine(const Camera& camera, const Photograph& photograph) const;

  // Adds a view that the atlas has stored in the view slot, at the refined pose, with the photograph that was refined;
  // `given` is the pose that the view came with. Balances all gains anew, and makes masks where enough views have come
  // since the last time. `face` is the face of each pixel, as in VisibilityBuffer, or empty: then it is found when
  // needed. Throws std::invalid_argument if `face` has another size.
  void add(ViewSlot slot, const Camera& given, const Refinement& refinement, std::span<const FaceId> face = {});
  // Takes over another depth and mask that the atlas has in the view slot. If its photograph has another size too, the
  // view is not refined any more.
  void refresh(ViewSlot slot);
  // Returns the pose that a stored view has once `given` is the pose that it came with: corrected by as much, seen from
  // the camera, as the pose before was.
  [[nodiscard]] Camera refined_from(ViewSlot slot, const Camera& given) const;
  // Takes over that the atlas has moved the view to `refined`, because `given` counts as the pose that it came with.
  void set_pose(ViewSlot slot, const Camera& given, const Camera& refined);
  // Sets what sees the mesh, after it has changed. `visibility` must outlive the refiner or the next call.
  void set_visibility(const Visibility& visibility);
  // Sets how depth edges are masked from now on. The options must pass check(); this is not checked here.
  void set_validity(const ValidityOptions& validity) { validity_ = validity; }
  // Forgets a view that is about to leave its view slot.
  void remove(ViewSlot slot);

  // Returns how many times a stored view was refined again because others had come.
  [[nodiscard]] std::uint64_t revisited() const { return revisited_; }
  // Returns whether views rest: see kComparisonsToRest.
  [[nodiscard]] bool at_rest() const { return still_ >= kComparisonsToRest; }
  // Returns how many comparisons were made in full: of offered views that were stored, of stored views again, and by
  // polish().
  [[nodiscard]] std::uint64_t compared_in_full() const { return compared_in_full_; }

  // Refines every stored view against the others once, all at the same time. The set as a whole stays where it was.
  // Where views rest and all have their given poses, they are compared in brief first; if none is to move, only
  // exposures are balanced.
  PolishStep polish();
  // Publishes all refined poses in the atlas: makes the depth of views that have moved since it was made, and the masks
  // of all stored views, each judged by all the others. Call it when all views are stored and polished.
  void publish_refined();
  // Gives all stored views the poses that estimate_poses() finds, from `most_points` points of each at most, if they
  // improve. A view keeps its pose if it would move by less than AlignmentOptions::least_move_px, or be further from
  // its given pose than max_move allows, at the scene's median depth. What the set has moved as a whole is taken back.
  // Exposures are balanced by what is compared next. Without AlignmentOptions::pose it does nothing, and says that no
  // view took part.
  PoseEstimate solve_poses(std::size_t most_points);
  // Estimates the lenses of the stored views. Changes nothing.
  [[nodiscard]] LensEstimates estimate_lenses(const LensOptions& options = {}) const;
  // Estimates the motions of the stored views while their shutters read them. Changes nothing.
  [[nodiscard]] ShutterEstimate estimate_shutters(const ShutterOptions& options = {}) const;
  // Gives the stored views of the lenses that are significant the poses of an estimate made since the last change, and
  // photographs without what is wrong with their lens, which `corrected` makes from the originals; depth and masks
  // follow, see kDepthStandsPx. What these views have moved as a whole is taken back. Throws
  // std::invalid_argument, and changes nothing, unless there is a camera for each slot, those of stored views of the
  // photographs' sizes, and unless each slot of a lens holds a view; what `corrected` throws; and std::invalid_argument
  // if it gives a photograph of another size.
  void correct_lenses(const LensEstimates& estimates, const CorrectedPhotograph& corrected);
  // Gives the stored views the poses of a significant estimate made since the last change, and photographs that were
  // straightened by its motions, which `corrected` makes from the originals; else as correct_lenses().
  void correct_shutters(const ShutterEstimate& estimate, const CorrectedPhotograph& corrected);

 private:
  [[nodiscard]] Refinement compare(const Camera& given, const Camera& start, const Pyramid& photograph,
                                   std::span<const SurfaceSample> samples, std::optional<ViewSlot> slot) const;
  // Compares in brief where that is enough, else in full as compare() does.
  [[nodiscard]] Refinement look_at(const Camera& camera, const Pyramid& photograph,
                                   std::span<const SurfaceSample> samples, std::optional<ViewSlot> slot) const;
  // Views whose exposure alone is refined never rest, because that is cheap.
  [[nodiscard]] bool may_be_brief() const { return at_rest() && options_.alignment.pose; }
  [[nodiscard]] bool says_enough(const Refinement& brief) const;
  [[nodiscard]] Camera sampling_camera(const Camera& camera) const;
  [[nodiscard]] std::vector<SurfaceSample> samples_of(const Camera& camera, const Pyramid& photograph) const;
  [[nodiscard]] std::vector<SurfaceSample> samples_of(ViewSlot slot) const;
  [[nodiscard]] VisibilityBuffer sight_of(ViewSlot slot, const Camera& camera) const;
  [[nodiscard]] VisibilityBuffer near_sight(const Camera& camera) const;
  void balance_exposures();
  [[nodiscard]] double median_depth() const;
  [[nodiscard]] std::vector<std::vector<SurfaceSample>> all_samples() const;
  void correct(std::span<const ViewSlot> slots, const std::vector<Camera>& cameras,
               const CorrectedPhotograph& corrected);
  void replace(ViewSlot slot, const Camera& camera, std::shared_ptr<const StoredPhotograph> photograph,
               std::vector<std::uint8_t> trust);
  void replace(ViewSlot slot, std::vector<std::uint8_t> trust);
  [[nodiscard]] bool depth_stands(ViewSlot slot) const;
  void move(ViewSlot slot, const Camera& camera);
  void mask(ViewSlot slot, TrustExtent extent);
  void choose_samples(ViewSlot slot);
  // May be called from several threads at once for different slots.
  [[nodiscard]] Refinement compare_again(ViewSlot slot);
  bool revisit(ViewSlot newest);
  void count_comparison(const Refinement& refinement);
  [[nodiscard]] bool all_as_given() const;
  [[nodiscard]] std::optional<PolishStep> found_in_place();
  void compare_exposures();

  Atlas& atlas_;
  const Visibility* visibility_;
  RefinementOptions options_;
  ValidityOptions validity_;
  std::vector<std::optional<ComparedView>> views_;  // by slot
  struct ChosenSamples {
    Camera camera;  // that they were chosen with
    std::vector<SurfaceSample> samples;
  };
  std::vector<std::optional<ChosenSamples>> samples_;  // by slot, once it was compared again
  // The faces that the stored view sees, by slot, so that they need not be traced again; empty: not known.
  std::vector<std::vector<SeenFaces>> seen_;
  std::vector<Camera> given_;               // by slot
  std::vector<std::uint32_t> neighbours_;   // by slot: how many views it was compared with
  std::vector<std::uint32_t> masked_with_;  // and how many of them when its mask was last made
  std::vector<std::uint64_t> visited_;      // and when it was last refined, in views stored until then
  std::uint64_t visits_ = 0;
  std::uint64_t revisited_ = 0;
  std::uint32_t still_ = 0;  // comparisons in a row that moved nothing
  std::uint64_t compared_in_full_ = 0;
  ExposureGraph exposures_;
};

}  // namespace lumatlas
