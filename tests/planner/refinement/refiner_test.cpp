// SPDX-License-Identifier: GPL-3.0-or-later
// Refinement as the planner uses it, on streams whose true poses and exposures are known.
#include "planner/refinement/refiner.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "planner/planner.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

PlannerOptions options_for_relief() {
  PlannerOptions options;
  options.coverage.ideal_distance = 4;
  options.min_view_gain = 0;  // keep whatever helps
  options.visibility_px = 80;
  options.refinement.samples = 800;
  options.refinement.sample_px = 120;
  options.refinement.trust.grid_px = 80;
  return options;
}

PlannerOptions relief_without_refinement() {
  PlannerOptions options = options_for_relief();
  options.refinement.alignment.pose = options.refinement.alignment.exposure = false;
  return options;
}

// One photograph of a walk before the wall: the pose that the stream gives, and the truth.
struct Frame {
  std::string name;
  Camera truth, given;
  glm::dvec3 exposure{1.0};
  std::vector<glm::dvec3> points;
};

struct ReliefStream {
  ReliefStream(std::uint32_t capacity, const PlannerOptions& options)
      : atlas(relief.surface, capacity), planner(atlas, *relief.visibility, options) {}

  // The first four frames are right, so that "right" means something; the others are off by `px` and `stops`.
  [[nodiscard]] Frame frame(std::size_t number, double px, double stops) const {
    const double turn = 2.4 * static_cast<double>(number);
    Frame result;
    result.name = "view " + std::to_string(number);
    result.truth = relief_camera({1.1 * std::cos(turn), 0.7 * std::sin(turn), 0.2 * std::sin(3 * turn)},
                                 {0.5 * std::cos(turn + 1), 0.4 * std::sin(turn + 1), 4});
    result.points = relief.points(result.truth, 16, 12);
    const bool right = number < 4 || px == 0;
    result.given =
        right ? result.truth : disturbed(result.truth, px, static_cast<std::uint32_t>(number), result.points);
    if (!right) result.exposure = glm::dvec3(std::exp2(stops * std::sin(5 * static_cast<double>(number))));
    return result;
  }
  Verdict offer(const Frame& frame) {
    return planner.offer(frame.name, frame.given, relief.photograph(frame.truth, frame.exposure));
  }
  std::vector<Frame> offer_all(std::size_t count, double px, double stops) {
    std::vector<Frame> frames;
    for (std::size_t i = 0; i < count; ++i) {
      frames.push_back(frame(i, px, stops));
      offer(frames.back());
    }
    return frames;
  }
  // Slot of the stored view with that name.
  [[nodiscard]] std::optional<ViewSlot> slot_of(const std::string& name) const {
    for (ViewSlot slot{0}; slot < atlas.capacity(); ++slot) {
      if (atlas.view(slot) && atlas.view(slot)->name == name) return slot;
    }
    return std::nullopt;
  }
  // Root mean square over the stored views of how far their poses are from the truth.
  [[nodiscard]] double stored_error_px(const std::vector<Frame>& frames) const {
    double sum = 0, count = 0;
    for (const Frame& f : frames) {
      const auto slot = slot_of(f.name);
      if (!slot) continue;
      const double error = pose_error_px(atlas.view(*slot)->camera, f.truth, f.points);
      sum += error * error;
      count += 1;
    }
    return std::sqrt(sum / count);
  }
  // Largest deviation, as a logarithm, of gain times exposure from what it is on the average.
  [[nodiscard]] double worst_exposure_error(const std::vector<Frame>& frames) const {
    std::vector<double> logs;
    for (const Frame& f : frames) {
      if (const auto slot = slot_of(f.name)) logs.push_back(std::log(atlas.gain(*slot).g * f.exposure.g));
    }
    double mean = 0, worst = 0;
    for (const double value : logs) mean += value / static_cast<double>(logs.size());
    for (const double value : logs) worst = std::max(worst, std::abs(value - mean));
    return worst;
  }

  Relief relief;
  Atlas atlas;
  Planner planner;
};

bool same_camera(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

void check_same_store(const Atlas& a, const Atlas& b) {
  const Snapshot first = a.snapshot(), second = b.snapshot();
  CHECK((first.references.offsets == second.references.offsets));
  CHECK((first.references.views == second.references.views));
  CHECK((first.gains == second.gains));
  REQUIRE(first.views.size() == second.views.size());
  for (std::size_t slot = 0; slot < first.views.size(); ++slot) {
    REQUIRE((first.views[slot] == nullptr) == (second.views[slot] == nullptr));
    if (!first.views[slot]) continue;
    CHECK((first.views[slot]->name == second.views[slot]->name));
    CHECK(same_camera(first.views[slot]->camera, second.views[slot]->camera));
    CHECK((first.views[slot]->mask->trust == second.views[slot]->mask->trust));
    CHECK((first.views[slot]->mask->validity == second.views[slot]->mask->validity));
    CHECK((first.views[slot]->mask->depth == second.views[slot]->mask->depth));
  }
}

TEST_CASE("disturbed poses end nearer to the truth than they were given, and gains make up for the exposures") {
  ReliefStream stream(16, options_for_relief());
  const std::vector<Frame> frames = stream.offer_all(14, 3, 1);
  REQUIRE(stream.atlas.size() >= 12);
  double given = 0, count = 0;
  for (const Frame& f : frames) {
    const auto slot = stream.slot_of(f.name);
    if (!slot) continue;
    const double before = pose_error_px(f.given, f.truth, f.points);
    given += before * before;
    count += 1;
    if (before == 0) continue;
    CAPTURE(f.name);
    CHECK(pose_error_px(stream.atlas.view(*slot)->camera, f.truth, f.points) < 0.5 * before);
  }
  given = std::sqrt(given / count);
  CHECK(stream.stored_error_px(frames) < 0.2 * given);
  // Gains differ by up to two stops; 3 % is what photographs of 8 bit and sub-pixel errors leave.
  CHECK(stream.worst_exposure_error(frames) < 0.03);
}

// Depth and mask of each stored view are those of the pose that it is stored with.
void check_whole(const ReliefStream& stream, const PlannerOptions& options) {
  for (ViewSlot slot{0}; slot < stream.atlas.capacity(); ++slot) {
    const auto view = stream.atlas.view(slot);
    if (!view) continue;
    CHECK_NOTHROW(check(view->camera));
    CHECK(view->mask->depth == stream.relief.visibility->trace(view->camera).depth);
    CHECK(view->mask->validity ==
          validity_mask(view->photograph->whole(), view->mask->depth.all(), view->mask->trust.all(), options.validity));
  }
}

TEST_CASE("each refined view has the depth and the mask of its refined pose") {
  const PlannerOptions options = options_for_relief();
  ReliefStream stream(16, options);
  stream.offer_all(8, 3, 1);
  stream.planner.refiner().polish();
  check_whole(stream, options);
  stream.planner.refiner().publish_refined();
  check_whole(stream, options);
}

TEST_CASE("a pose that polishing moves by a little is in the store once that has settled") {
  ReliefStream stream(16, options_for_relief());
  const std::vector<Frame> frames = stream.offer_all(8, 1, 0);
  stream.planner.refiner().polish();
  // How many stored views settling moves; each by no more than depth stands for.
  const auto moved_by_settling = [&] {
    const Snapshot before = stream.atlas.snapshot();
    stream.planner.refiner().publish_refined();
    std::size_t moved = 0;
    for (const Frame& f : frames) {
      const ViewSlot slot(stream.slot_of(f.name).value());
      const Camera& after = stream.atlas.view(slot)->camera;
      CHECK(pose_error_px(before.views[slot]->camera, after, f.points) < kDepthStandsPx);
      moved += !same_camera(before.views[slot]->camera, after);
    }
    return moved;
  };
  CHECK(moved_by_settling() > 0);
  CHECK(moved_by_settling() == 0);
}

// A frame of the walk that shows another part of the wall than its pose says, one of many.
Frame misplaced_frame(const ReliefStream& stream, std::size_t number) {
  Frame lost = stream.frame(9, 0, 0);
  const double turn = 0.61 * static_cast<double>(number);
  const glm::dvec3 aside(std::cos(turn), std::sin(turn), 0);
  lost.truth = relief_camera(glm::dvec3(1.9, 1.5, 0) * aside + glm::dvec3(0, 0, 0.3),
                             glm::dvec3(2.2, 1.7, 0) * aside + glm::dvec3(0, 0, 4));
  return lost;
}

TEST_CASE("views with the pose of another place are outliers and leave the store as it was") {
  ReliefStream stream(16, options_for_relief()), untouched(16, options_for_relief());
  for (std::size_t i = 0; i < 8; ++i) {
    stream.offer(stream.frame(i, 1, 0.5));
    untouched.offer(untouched.frame(i, 1, 0.5));
  }
  const double coverage = stream.planner.store().summed_coverage();
  for (std::size_t number = 0; number < 12; ++number) {
    CAPTURE(number);
    const Verdict verdict = stream.offer(misplaced_frame(stream, number));
    CHECK(verdict.decision == Decision::outlier);
    CHECK_FALSE(verdict.slot);
    CHECK(verdict.replaced.empty());
    REQUIRE(verdict.refinement);
    CHECK(verdict.refinement->outlier);
    REQUIRE(verdict.refinement->alignment.correlation);
    CHECK(*verdict.refinement->alignment.correlation < options_for_relief().refinement.least_correlation);
  }
  CHECK(stream.planner.store().summed_coverage() == Approx(coverage).epsilon(1e-12));  // sums in another order
  check_same_store(stream.atlas, untouched.atlas);
  const Frame next = stream.frame(10, 1, 0.5);
  CHECK(stream.offer(next).decision == untouched.offer(next).decision);
  check_same_store(stream.atlas, untouched.atlas);
}

TEST_CASE("a reserved view that turns out to be an outlier gives its slot back, and another can be offered again") {
  ReliefStream ahead(9, options_for_relief()), untouched(9, options_for_relief());
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < 8; ++i) frames.push_back(ahead.frame(i, 1, 0.5));
  frames.push_back(misplaced_frame(ahead, 3));
  std::vector<Verdict> verdicts;
  for (const Frame& f : frames) verdicts.push_back(ahead.planner.reserve(f.name, f.given));
  const Frame late = ahead.frame(10, 1, 0.5);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    REQUIRE(verdicts[i].decision == Decision::kept);
    ahead.planner.store_reserved(
        frames[i].name, [&] { return ahead.relief.photograph(frames[i].truth, frames[i].exposure); }, verdicts[i]);
    if (i < 8) untouched.offer(frames[i]);
  }
  CHECK(verdicts.back().decision == Decision::outlier);
  CHECK_FALSE(verdicts.back().slot);
  CHECK(verdicts.back().replaced.empty());
  CHECK(ahead.planner.store().summed_coverage() == Approx(untouched.planner.store().summed_coverage()).epsilon(1e-12));
  check_same_store(ahead.atlas, untouched.atlas);
  const Verdict again = ahead.planner.offer_again(late.name, late.given,
                                                  [&] { return ahead.relief.photograph(late.truth, late.exposure); });
  CHECK(again.decision == Decision::kept);
  CHECK(again.slot == 8u);
}

TEST_CASE("a view with the pose of another place is kept where too few others show what it should") {
  PlannerOptions options = options_for_relief();
  options.refinement.least_views = 5;
  ReliefStream stream(16, options);
  for (std::size_t i = 0; i < 4; ++i) stream.offer(stream.frame(i, 0, 0));
  CHECK(stream.offer(misplaced_frame(stream, 0)).decision == Decision::kept);
}

TEST_CASE("a view that no other overlaps is never an outlier") {
  ReliefStream stream(4, options_for_relief());
  const Verdict first = stream.offer(stream.frame(0, 0, 0));
  CHECK(first.decision == Decision::kept);
  REQUIRE(first.refinement);
  CHECK(first.refinement->points == 0);
  CHECK_FALSE(first.refinement->outlier);
  CHECK(same_camera(stream.atlas.view(0)->camera, stream.frame(0, 0, 0).given));
  CHECK(stream.atlas.gain(0) == glm::dvec3(1));
}

TEST_CASE("refining changes neither the store nor what refining again says") {
  ReliefStream stream(8, options_for_relief()), untouched(8, options_for_relief());
  for (std::size_t i = 0; i < 6; ++i) {
    stream.offer(stream.frame(i, 2, 0.5));
    untouched.offer(untouched.frame(i, 2, 0.5));
  }
  Refiner refiner(stream.atlas, *stream.relief.visibility, options_for_relief().refinement);
  const Frame next = stream.frame(7, 2, 0.5);
  const Photograph photograph = stream.relief.photograph(next.truth, next.exposure);
  const Refinement once = refiner.refine(next.given, photograph);
  const Refinement twice = refiner.refine(next.given, photograph);
  CHECK(same_camera(once.alignment.camera, twice.alignment.camera));
  check_same_store(stream.atlas, untouched.atlas);
}

TEST_CASE("without refinement every kept view has the camera that it came with, a gain of one and no trust mask") {
  ReliefStream stream(5, relief_without_refinement());
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < 12; ++i) {
    frames.push_back(stream.frame(i, 3, 1));
    const Verdict verdict = stream.offer(frames.back());
    CHECK_FALSE(verdict.refinement);
    CHECK(verdict.refine_ms == 0);
    CHECK(verdict.decision != Decision::outlier);
  }
  std::size_t found = 0;
  for (const Frame& f : frames) {
    const auto slot = stream.slot_of(f.name);
    if (!slot) continue;
    ++found;
    CHECK(same_camera(stream.atlas.view(*slot)->camera, f.given));
    CHECK(stream.atlas.gain(*slot) == glm::dvec3(1));
    CHECK(stream.atlas.view(*slot)->mask->trust.empty());
  }
  CHECK(found == 5);
}

TEST_CASE("which views are kept, and where, does not depend on refinement, unless one is an outlier") {
  ReliefStream refined(5, options_for_relief()), plain(5, relief_without_refinement());
  for (std::size_t i = 0; i < 12; ++i) {
    const Frame f = refined.frame(i, 2, 1);
    const Verdict a = refined.offer(f), b = plain.offer(f);
    CHECK(a.decision == b.decision);
    CHECK(a.slot == b.slot);
    CHECK(a.replaced == b.replaced);
    CHECK(a.gain == b.gain);
  }
}

TEST_CASE("exposure alone leaves the poses, and the pose alone leaves the gains") {
  PlannerOptions options = options_for_relief();
  options.refinement.alignment.pose = false;
  ReliefStream exposure_only(8, options);
  const std::vector<Frame> frames = exposure_only.offer_all(7, 0.5, 1);
  for (const Frame& f : frames) {
    const auto slot = exposure_only.slot_of(f.name);
    if (slot) CHECK(same_camera(exposure_only.atlas.view(*slot)->camera, f.given));
  }
  CHECK(exposure_only.worst_exposure_error(frames) < 0.03);

  options = options_for_relief();
  options.refinement.alignment.exposure = false;
  ReliefStream pose_only(8, options);
  const std::vector<Frame> even = pose_only.offer_all(7, 3, 0);
  for (const Frame& f : even) {
    if (const auto slot = pose_only.slot_of(f.name)) CHECK(pose_only.atlas.gain(*slot) == glm::dvec3(1));
  }
  CHECK(pose_only.stored_error_px(even) < 1);
}

TEST_CASE("polishing lowers the mean residual and comes to rest") {
  PlannerOptions options = options_for_relief();
  ReliefStream stream(16, options);
  const std::vector<Frame> frames = stream.offer_all(12, 6, 1);
  PolishStep last = stream.planner.refiner().polish();
  const PolishStep first = last;
  CHECK(first.residual_after <= first.residual_before);
  for (int step = 0; step < 4; ++step) {
    const double so_far = last.residual_after;
    last = stream.planner.refiner().polish();
    CHECK(last.residual_after <= last.residual_before);
    // Where the step before it has left off, but for what the others' moves have changed in the medians.
    CHECK(last.residual_before == Approx(so_far).epsilon(0.25));
  }
  CHECK(last.residual_after <= first.residual_before);
  CHECK(last.residual_after < 0.02);
  // As a set the views stay where their given poses put them, which is off by the mean of twelve errors of 6 px or
  // less.
  CHECK(stream.stored_error_px(frames) < 6 / std::sqrt(12.0));
}

// A refiner without a planner: the test says which views are stored, and when cells refer to them.
struct RefinerAlone {
  explicit RefinerAlone(std::uint32_t views)
      : atlas(relief.surface, views), refiner(atlas, *relief.visibility, poses()) {}

  static RefinementOptions poses() {
    RefinementOptions options = options_for_relief().refinement;
    options.trust.enabled = false;
    return options;
  }

  void store(const Frame& f, bool compared) {
    const Photograph photograph = relief.photograph(f.truth);
    const Refinement refinement = compared ? refiner.refine(f.given, photograph) : Refinement{};
    slots.push_back(atlas.insert(
        make_stored_view(f.name, f.given, photograph, relief.visibility->trace(f.given), ValidityOptions{})));
    refiner.add(slots.back(), f.given, refinement);
  }

  // So many, as they came, with poses wrong by `px`; cells refer to all of them.
  std::vector<Frame> store_as_given(std::size_t count, double px) {
    std::vector<Frame> frames;
    for (std::size_t i = 0; i < count; ++i) {
      frames.push_back(walk.frame(i, px, 0));
      store(frames.back(), false);
    }
    refer_to_all();
    return frames;
  }

  // Nothing is compared with views that no cell refers to.
  void refer_to_all() {
    for (CellId cell{0}; cell < relief.surface->cells.cells.size(); ++cell) atlas.set_references(cell, slots);
  }

  Relief relief;
  Atlas atlas;
  Refiner refiner;
  ReliefStream walk{1, options_for_relief()};
  std::vector<ViewSlot> slots;
};

TEST_CASE("polishing improves a store whose poses were stored as they came") {
  RefinerAlone alone(10);
  const std::vector<Frame> frames = alone.store_as_given(10, 2);
  const auto error = [&] {
    double sum = 0;
    for (ViewSlot slot{0}; slot < 10; ++slot) {
      sum += pose_error_px(alone.atlas.view(slot)->camera, frames[slot].truth, frames[slot].points);
    }
    return sum / 10;
  };
  const double given = error();
  const PolishStep first = alone.refiner.polish();
  CHECK(first.moved_px > 0.3);
  CHECK(first.residual_after < 0.9 * first.residual_before);
  PolishStep last;
  for (int step = 0; step < 3; ++step) last = alone.refiner.polish();
  CHECK(last.residual_after < 0.6 * first.residual_before);
  alone.refiner.publish_refined();
  CHECK(error() < 0.5 * given);
}

TEST_CASE("a pose that is far from the one in the store is there before that settles") {
  RefinerAlone alone(10);
  const std::vector<Frame> frames = alone.store_as_given(10, 6);
  for (int step = 0; step < 4; ++step) (void)alone.refiner.polish();
  std::size_t moved = 0;
  for (ViewSlot slot{0}; slot < 10; ++slot) {
    const Camera before = alone.atlas.view(slot)->camera;
    moved += pose_error_px(before, frames[slot].given, frames[slot].points) > kDepthStandsPx;
  }
  CHECK(moved > 5);
  const Snapshot polished = alone.atlas.snapshot();
  alone.refiner.publish_refined();
  for (ViewSlot slot{0}; slot < 10; ++slot) {
    const Camera& after = alone.atlas.view(slot)->camera;
    CHECK(pose_error_px(polished.views[slot]->camera, after, frames[slot].points) < kDepthStandsPx);
  }
}

TEST_CASE("a view that stays where it was given is not made anew, and one that moves is") {
  PlannerOptions options = options_for_relief();
  options.refinement.trust.enabled = false;  // so that only a pose can be the reason
  const auto stored = [](const ReliefStream& stream) {
    std::vector<std::shared_ptr<const StoredView>> views;
    for (ViewSlot slot{0}; slot < 6; ++slot) views.push_back(stream.atlas.view(slot));
    return views;
  };
  ReliefStream right(16, options);
  right.offer_all(6, 0, 0);
  const auto before = stored(right);
  CHECK(right.planner.refiner().polish().moved_px == 0);
  right.planner.refiner().publish_refined();
  for (std::size_t i = 6; i < 12; ++i) right.offer(right.frame(i, 0, 0));  // each of which visits two again
  CHECK(stored(right) == before);

  ReliefStream wrong(16, options);
  wrong.offer_all(6, 6, 0);
  const auto given = stored(wrong);
  CHECK(wrong.planner.refiner().polish().moved_px > 0);
  wrong.planner.refiner().publish_refined();
  CHECK(stored(wrong) != given);
}

// Counts how often it is asked what a camera sees.
class CountingVisibility : public Visibility {
 public:
  explicit CountingVisibility(const Visibility& visibility) : visibility_(visibility) {}
  void trace(const Camera& camera, VisibilityBuffer& buffer) const override {
    ++traced;
    visibility_.trace(camera, buffer);
  }
  mutable std::atomic<int> traced = 0;

 private:
  const Visibility& visibility_;
};

TEST_CASE("a view that stays is compared at the points that were chosen before, until the mesh changes") {
  const Relief relief;
  Atlas atlas(relief.surface, 6);
  const CountingVisibility counting(*relief.visibility);
  PlannerOptions options = options_for_relief();
  options.refinement.trust.enabled = false;
  options.refinement.revisits = 0;
  Refiner refiner(atlas, counting, options.refinement);
  const ReliefStream walk(1, options);
  for (std::size_t i = 0; i < 6; ++i) {
    const Frame f = walk.frame(i, 0, 0);
    const ViewSlot slot = atlas.insert(make_stored_view(f.name, f.given, relief.photograph(f.truth),
                                                        relief.visibility->trace(f.given), ValidityOptions{}));
    refiner.add(slot, f.given, Refinement{});
  }
  for (CellId cell{0}; cell < relief.surface->cells.cells.size(); ++cell) {
    atlas.set_references(cell, {0, 1, 2, 3, 4, 5});
  }
  const auto polished = [&] {
    counting.traced = 0;
    const PolishStep step = refiner.polish();
    CHECK(step.views == 6);
    CHECK(step.moved_px == 0);
    return std::pair(step.residual_after, counting.traced.load());
  };
  const auto first = polished();
  CHECK(first.second == 6);
  const auto second = polished();
  CHECK(second.second == 0);
  CHECK(second.first == Approx(first.first).epsilon(1e-3));  // gains are balanced between the two
  counting.traced = 0;
  CHECK(refiner.estimate_lenses().views == 6);
  CHECK(counting.traced == 0);
  refiner.set_visibility(counting);
  CHECK(polished().second == 6);
}

TEST_CASE("what a view sees is asked once for its place and its masks, and masks are the same as without it") {
  const Relief relief;
  const CountingVisibility counting(*relief.visibility);
  const PlannerOptions options = options_for_relief();
  const auto store = [&](Atlas& atlas, Refiner& refiner, bool with_faces) {
    const ReliefStream walk(1, options);
    for (CellId cell{0}; cell < relief.surface->cells.cells.size(); ++cell) atlas.set_references(cell, {});
    for (std::size_t i = 0; i < 6; ++i) {
      const Frame f = walk.frame(i, 0, 0);
      VisibilityBuffer visible = relief.visibility->trace(f.given);
      const std::vector<FaceId> face = with_faces ? visible.face : std::vector<FaceId>();
      Photograph photograph = relief.photograph(f.truth);
      if (i == 5) std::fill(photograph.rgb.begin(), photograph.rgb.begin() + 3 * 40 * photograph.width, 40);
      TiledView tiled = make_tiled_view(f.name, f.given, std::move(photograph), std::move(visible),
                                        relief.surface->cells, atlas.layout(), ValidityOptions{});
      const ViewSlot slot = atlas.insert(std::move(tiled.view), std::move(tiled.shown));
      refiner.add(slot, f.given, Refinement{}, face);
    }
    for (CellId cell{0}; cell < relief.surface->cells.cells.size(); ++cell) {
      atlas.set_references(cell, {0, 1, 2, 3, 4, 5});
    }
    counting.traced = 0;
    refiner.publish_refined();
    return counting.traced.load();
  };
  const TileOptions layout{.tile_px = 32};
  Atlas told(relief.surface, 6, layout), asked(relief.surface, 6, layout);
  Refiner with(told, counting, options.refinement), without(asked, counting, options.refinement);
  const int traced_with = store(told, with, true), traced_without = store(asked, without, false);
  CHECK(traced_with == 0);
  CHECK(traced_without > 6);  // for masks, and for a place once a mask is another
  bool any_masked = false;
  for (ViewSlot slot{0}; slot < 6; ++slot) {
    CHECK(told.view(slot)->mask->depth == asked.view(slot)->mask->depth);
    CHECK(told.view(slot)->mask->validity == asked.view(slot)->mask->validity);
    any_masked = any_masked || !told.view(slot)->mask->trust.empty();
    const auto a = told.snapshot(), b = asked.snapshot();
    CHECK(a.tiles.places == b.tiles.places);
  }
  CHECK(any_masked);
  CHECK_THROWS_WITH(with.add(0, told.view(0)->camera, Refinement{}, std::vector<FaceId>(3, 0)),
                    Catch::Contains("the size of face is 3, must be the number of the view's pixels"));
}

TEST_CASE("stored views are refined again while any moves, rest where none does, and wake when one moves") {
  ReliefStream right(40, options_for_relief());
  right.offer_all(1, 0, 0);
  CHECK(right.planner.refiner().revisited() == 0);  // there is no other
  for (std::size_t i = 1; i < 30; ++i) right.offer(right.frame(i, 0, 0));
  const std::uint64_t until_rest = right.planner.refiner().revisited();
  CHECK(until_rest > 0);
  CHECK(until_rest <= kComparisonsToRest);

  const ReliefStream walk(1, options_for_relief());
  bool moved = false;
  for (std::size_t i = 30; i < 36 && !moved; ++i) {
    const std::uint64_t before = right.planner.refiner().revisited();
    const Verdict verdict = right.offer(walk.frame(i, 4, 0));
    if (verdict.decision != Decision::kept) continue;
    REQUIRE(verdict.refinement);
    moved = verdict.refinement->alignment.moved;
    CHECK(right.planner.refiner().revisited() == before + (moved ? options_for_relief().refinement.revisits : 0));
  }
  CHECK(moved);

  ReliefStream wrong(40, options_for_relief());
  wrong.offer_all(30, 4, 0);
  CHECK(wrong.planner.refiner().revisited() > until_rest + 10);
}

// The share of the stored views that have other poses than they were given.
double share_off_given(const ReliefStream& stream, const std::vector<Frame>& frames) {
  double off = 0, stored = 0;
  for (const Frame& f : frames) {
    const auto slot = stream.slot_of(f.name);
    if (!slot) continue;
    stored += 1;
    off += same_camera(stream.atlas.view(*slot)->camera, f.given) ? 0 : 1;
  }
  return off / stored;
}

// As a sensor has it: what is left of a residual does not depend on the last hundredth of a pixel.
Photograph with_noise(Photograph photograph, std::uint32_t seed) {
  std::mt19937 random(seed);
  for (std::uint8_t& value : photograph.rgb) {
    value =
        static_cast<std::uint8_t>(std::clamp(static_cast<int>(value) + static_cast<int>(random() % 17) - 8, 0, 255));
  }
  return photograph;
}

TEST_CASE("views that were given wrong poses rest once they are right, and are not made anew by being looked at") {
  PlannerOptions options = options_for_relief();
  options.refinement.trust.enabled = false;  // so that only a pose can be the reason
  ReliefStream stream(80, options);
  const auto offer = [&](std::size_t number, double px) {
    const Frame f = stream.frame(number, px, 0);
    stream.planner.offer(f.name, f.given,
                         with_noise(stream.relief.photograph(f.truth), static_cast<std::uint32_t>(number)));
    return f;
  };
  std::vector<Frame> wrong;
  for (std::size_t i = 0; i < 24; ++i) {
    const Frame f = offer(i, i % 3 == 2 ? 4 : 0);
    if (i > 4 && i % 3 == 2) wrong.push_back(f);
  }
  REQUIRE(share_off_given(stream, wrong) == 1);
  // What comes from here on needs no refinement, so that those who need it no more can be left alone.
  for (std::size_t i = 24; i < 54; ++i) offer(i, 0);
  const std::uint64_t until_rest = stream.planner.refiner().revisited();
  std::vector<std::shared_ptr<const StoredView>> before;
  for (ViewSlot slot{0}; slot < 24; ++slot) before.push_back(stream.atlas.view(slot));
  for (std::size_t i = 54; i < 66; ++i) offer(i, 0);
  CHECK(stream.planner.refiner().revisited() == until_rest);
  for (ViewSlot slot{0}; slot < 24; ++slot) CHECK(stream.atlas.view(slot) == before[slot]);
}

// As the walk goes on, all poses right, until the planner rests and further.
std::vector<Frame> offer_right(ReliefStream& stream, std::size_t count) {
  std::vector<Frame> frames;
  for (std::size_t i = 0; i < count; ++i) {
    frames.push_back(stream.frame(i, 0, 0));
    const Frame& f = frames.back();
    stream.planner.offer(f.name, f.given, with_noise(stream.relief.photograph(f.truth), static_cast<std::uint32_t>(i)));
  }
  return frames;
}

TEST_CASE("a scene with exact poses is left as it is, and no more is compared in full than it takes to rest") {
  ReliefStream stream(40, options_for_relief());
  const std::vector<Frame> frames = offer_right(stream, 34);
  REQUIRE(stream.atlas.size() == 34);
  const std::uint64_t most = kComparisonsToRest + options_for_relief().refinement.revisits + 1;
  CHECK(stream.planner.refiner().compared_in_full() <= most);
  const PolishStep step = stream.planner.refiner().polish();
  CHECK(step.views == 34);  // each was looked at
  CHECK(step.moved_px == 0);
  CHECK(step.residual_after == step.residual_before);
  CHECK(stream.planner.refiner().compared_in_full() <= most);
  CHECK(share_off_given(stream, frames) == 0);
  CHECK(stream.worst_exposure_error(frames) < 0.01);
}

TEST_CASE("a scene of which only later views are wrong is refined all the same") {
  ReliefStream stream(40, options_for_relief());
  offer_right(stream, 24);
  const std::uint64_t until_rest = stream.planner.refiner().compared_in_full();
  std::size_t wrong = 0;
  for (std::size_t i = 24; i < 36; ++i) {
    const Frame f = stream.frame(i, i % 3 == 2 ? 3 : 0, 1);
    if (stream.offer(f).decision != Decision::kept || i % 3 != 2) continue;
    CAPTURE(f.name);
    CHECK(pose_error_px(stream.atlas.view(stream.slot_of(f.name).value())->camera, f.truth, f.points) <
          0.5 * pose_error_px(f.given, f.truth, f.points));
    ++wrong;
  }
  REQUIRE(wrong == 4);
  CHECK(stream.planner.refiner().compared_in_full() > until_rest + wrong);
  const std::uint64_t before = stream.planner.refiner().compared_in_full();
  CHECK(stream.planner.refiner().polish().views == stream.atlas.size());
  CHECK(stream.planner.refiner().compared_in_full() == before + stream.atlas.size());
}

TEST_CASE("while views rest exposures are found nearly as well as in full") {
  ReliefStream stream(40, options_for_relief());
  std::vector<Frame> frames = offer_right(stream, 12);
  for (std::size_t i = 12; i < 34; ++i) {
    frames.push_back(stream.frame(i, 0, 0));
    frames.back().exposure = glm::dvec3(std::exp2(std::sin(5 * static_cast<double>(i))));
    stream.offer(frames.back());
  }
  CHECK(stream.worst_exposure_error(frames) < 0.03);  // as where poses and exposures are wrong
  CHECK(stream.planner.refiner().polish().moved_px == 0);
  CHECK(stream.worst_exposure_error(frames) < 0.03);
}

TEST_CASE("polishing finds a wrong pose that was never compared, however long views have rested") {
  RefinerAlone alone(20);
  for (std::size_t i = 0; i < 19; ++i) {
    alone.store(alone.walk.frame(i, 0, 0), true);
    alone.refer_to_all();
  }
  REQUIRE(alone.refiner.at_rest());
  const Frame wrong = alone.walk.frame(19, 3, 0);
  alone.store(wrong, false);
  alone.refer_to_all();
  REQUIRE(alone.refiner.at_rest());
  CHECK(alone.refiner.polish().moved_px > 0);
  CHECK(pose_error_px(alone.atlas.view(alone.slots.back())->camera, wrong.truth, wrong.points) <
        0.5 * pose_error_px(wrong.given, wrong.truth, wrong.points));
}

// The poses of three views of which the first two overlap little, so that most of what they are compared with is the
// third, which has another exposure; the second was given a wrong pose.
std::vector<double> errors_with_newcomer(double exposure) {
  PlannerOptions options = options_for_relief();
  options.refinement.trust.enabled = false;
  ReliefStream stream(4, options);
  std::vector<Frame> frames;
  for (const double x : {-0.9, 0.9, 0.0}) {
    Frame f;
    f.name = "view " + std::to_string(frames.size());
    f.truth = f.given = relief_camera({x, 0, 0}, {1.5 * x, 0.1, 4});
    f.points = stream.relief.points(f.truth, 16, 12);
    if (frames.size() == 1) f.given = disturbed(f.truth, 3, 7, f.points);
    if (frames.size() == 2) f.exposure = glm::dvec3(exposure);
    stream.offer(f);
    frames.push_back(f);
  }
  CHECK(stream.planner.refiner().revisited() >= 3);
  std::vector<double> errors;
  for (const Frame& f : frames) {
    errors.push_back(pose_error_px(stream.atlas.view(stream.slot_of(f.name).value())->camera, f.truth, f.points));
  }
  return errors;
}

TEST_CASE("a newcomer's exposure does not spoil the poses of the few views that it is compared with") {
  const std::vector<double> alike = errors_with_newcomer(1);
  for (const double exposure : {0.25, 4.0}) {
    CAPTURE(exposure);
    const std::vector<double> errors = errors_with_newcomer(exposure);
    // Dark and clipped pixels say less, so not as good to the last bit.
    for (std::size_t i = 0; i < errors.size(); ++i) CHECK(errors[i] < alike[i] + 0.05);
  }
}

TEST_CASE("polishing, masks and cameras can be stopped between one view and the next, and the store is whole after") {
  struct Stop {};
  PlannerOptions options = options_for_relief();
  int calls_left = 1000;
  options.refinement.cancel_check = [&] {
    if (--calls_left < 0) throw Stop();
  };
  ReliefStream stream(8, options);
  const std::vector<Frame> frames = stream.offer_all(8, 4, 1);
  LensEstimates estimates = stream.planner.refiner().estimate_lenses();
  for (LensEstimate& lens : estimates.lenses) lens.significant = true;
  const auto as_it_is = [&](ViewSlot slot, const std::string&) { return stream.atlas.view(slot)->photograph->whole(); };
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  for (const int calls : {0, 3, 8, 11}) {
    CAPTURE(calls);
    calls_left = calls;
    CHECK_THROWS_AS(stream.planner.refiner().polish(), Stop);
    calls_left = std::min(calls, 7);
    CHECK_THROWS_AS(stream.planner.refiner().publish_refined(), Stop);
    calls_left = std::min(calls, 7);
    CHECK_THROWS_AS(stream.planner.refiner().correct_lenses(estimates, as_it_is), Stop);
    calls_left = calls;
    CHECK_THROWS_AS(stream.planner.refiner().estimate_lenses(), Stop);
    for (const Frame& f : frames) {
      const auto view = stream.atlas.view(stream.slot_of(f.name).value());
      CHECK_NOTHROW(check(view->camera));
      CHECK(view->mask->depth == stream.relief.visibility->trace(view->camera).depth);
    }
  }
  calls_left = 1000;
  CHECK(stream.planner.refiner().polish().views == 8);
}

TEST_CASE("polishing a store of one view, or of none, changes nothing") {
  ReliefStream stream(4, options_for_relief());
  CHECK(stream.planner.refiner().polish().moved_px == 0);
  const Frame only = stream.frame(0, 0, 0);
  stream.offer(only);
  const PolishStep step = stream.planner.refiner().polish();
  CHECK(step.residual_after == 0);
  CHECK(same_camera(stream.atlas.view(0)->camera, only.given));
}

TEST_CASE("the exposure of a view that has left says nothing about the one that takes its slot") {
  ReliefStream stream(2, options_for_relief());
  Refiner refiner(stream.atlas, *stream.relief.visibility, options_for_relief().refinement);
  const auto store = [&](std::size_t number, std::vector<ExposureRatio> ratios) {
    const Frame f = stream.frame(number, 0, 0);
    const std::uint32_t slot =
        stream.atlas.insert(make_stored_view(f.name, f.given, stream.relief.photograph(f.truth),
                                             stream.relief.visibility->trace(f.given), ValidityOptions{}));
    Refinement refinement;
    refinement.ratios = std::move(ratios);
    refiner.add(ViewSlot(slot), f.given, refinement);
    return slot;
  };
  REQUIRE(store(0, {}) == 0);
  REQUIRE(store(1, {{0, glm::dvec3(0.5), glm::dvec3(0.5), 400}}) == 1);
  CHECK(std::log(stream.atlas.gain(1).g / stream.atlas.gain(0).g) == Approx(0.5).margin(2e-3));
  refiner.remove(0);
  stream.atlas.erase(0);
  REQUIRE(store(2, {}) == 0);
  CHECK(stream.atlas.gain(0) == glm::dvec3(1));
  CHECK(stream.atlas.gain(1) == glm::dvec3(1));
}

TEST_CASE("the exposures of views that leave for one say nothing about it, nor about those that take their slots") {
  ReliefStream stream(2, options_for_relief());
  Refiner refiner(stream.atlas, *stream.relief.visibility, options_for_relief().refinement);
  const auto store = [&](std::size_t number, std::vector<ExposureRatio> ratios) {
    const Frame f = stream.frame(number, 0, 0);
    Refinement refinement;
    refinement.ratios = std::move(ratios);
    refiner.add(stream.atlas.insert(make_stored_view(f.name, f.given, stream.relief.photograph(f.truth),
                                                     stream.relief.visibility->trace(f.given), ValidityOptions{})),
                f.given, refinement);
  };
  store(0, {});
  store(1, {});
  for (const std::uint32_t slot : {0u, 1u}) {
    refiner.remove(ViewSlot(slot));
    stream.atlas.erase(ViewSlot(slot));
  }
  // It was compared with both while they were there.
  const glm::dvec3 brighter(0.5);
  store(2, {{0, brighter, brighter, 400}, {1, brighter, brighter, 400}});
  store(3, {});
  CHECK(stream.atlas.gain(0) == glm::dvec3(1));
  CHECK(stream.atlas.gain(1) == glm::dvec3(1));
}

TEST_CASE("a store of three views goes on refining while others are offered and take their places") {
  ReliefStream stream(3, options_for_relief());
  std::vector<Frame> frames;
  std::size_t replaced = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    frames.push_back(stream.frame(i, 1, 0.5));
    replaced += stream.offer(frames.back()).decision == Decision::replaced;
    REQUIRE(stream.atlas.size() <= 3);
  }
  CHECK(replaced >= 1);
  CHECK(stream.atlas.size() == 3);
  CHECK(stream.worst_exposure_error(frames) < 0.05);
  CHECK_NOTHROW(stream.planner.refiner().publish_refined());
  const PolishStep step = stream.planner.refiner().polish();
  CHECK(step.residual_after <= step.residual_before);
  for (ViewSlot slot{0}; slot < 3; ++slot) CHECK_NOTHROW(check(stream.atlas.view(slot)->camera));
}

TEST_CASE(
    "a passer-by in one photograph is masked once enough others have come, and stays masked when they are polished") {
  ReliefStream stream(12, options_for_relief());
  for (std::size_t i = 0; i < 8; ++i) {
    const Frame f = stream.frame(i, 0, 0);
    Photograph photograph = stream.relief.photograph(f.truth);
    for (std::uint32_t y = 50; i == 1 && y < 120; ++y) {
      for (std::uint32_t x = 90; x < 150; ++x) {
        std::uint8_t* rgb = &photograph.rgb[3 * (std::size_t{y} * 240 + x)];
        rgb[0] = 210, rgb[1] = 20, rgb[2] = 30;
      }
    }
    stream.planner.offer(f.name, f.given, photograph);
  }
  const ViewSlot slot(stream.slot_of("view 1").value());
  REQUIRE_FALSE(stream.atlas.view(slot)->mask->trust.empty());
  CHECK(static_cast<int>(stream.atlas.view(slot)->mask->trust[85 * 240 + 120]) == 0);
  stream.planner.refiner().polish();
  stream.planner.refiner().publish_refined();
  REQUIRE_FALSE(stream.atlas.view(slot)->mask->trust.empty());
  CHECK(static_cast<int>(stream.atlas.view(slot)->mask->trust[85 * 240 + 120]) == 0);
  for (std::uint32_t other = 0; other < 8; ++other) {
    if (other != slot && stream.atlas.view(ViewSlot(other)))
      CHECK(stream.atlas.view(ViewSlot(other))->mask->trust.empty());
  }
}

TEST_CASE("the same stream with refinement, masks and polishing gives the same store on one thread as on four") {
  const auto stream_on = [](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    auto stream = std::make_unique<ReliefStream>(5, options_for_relief());
    stream->offer_all(9, 2, 1);
    stream->planner.refiner().polish();
    stream->planner.refiner().publish_refined();
    return stream;
  };
  const auto one = stream_on(1), four = stream_on(4);
  check_same_store(one->atlas, four->atlas);
}

TEST_CASE("refinement options that break a rule are refused by name") {
  const auto refusal_of = [](const auto& change) { return refusal<RefinementOptions>(change); };
  CHECK(refusal_of([](RefinementOptions& o) { o.samples = 0; }) == "refinement: samples is 0, must be at least 1");
  CHECK(refusal_of([](RefinementOptions& o) { o.sample_px = 0; }) == "refinement: sample_px is 0, must be at least 1");
  CHECK(refusal_of([](RefinementOptions& o) { o.least_correlation = 1.5; }) ==
        "refinement: least_correlation is 1.5, must be in [-1, 1]");
  CHECK(refusal_of([](RefinementOptions& o) { o.least_views = -1; }) ==
        "refinement: least_views is -1, must be not negative");
  CHECK(refusal_of([](RefinementOptions& o) { o.alignment.levels = 0; }) ==
        "alignment: levels is 0, must be at least 1");
  CHECK(refusal_of([](RefinementOptions&) {}) == "accepted");
}

}  // namespace
}  // namespace lumatlas
