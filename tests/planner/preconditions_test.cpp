// SPDX-License-Identifier: GPL-3.0-or-later
// What the planner's functions refuse to be given: the field, its value and the rule, one by one. Options have their
// refusals beside their own tests.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "planner/coverage/cell_coverage.h"
#include "planner/coverage/cell_demand.h"
#include "planner/coverage/coverage_ledger.h"
#include "planner/coverage/direction_coverage.h"
#include "planner/coverage/offered_coverage.h"
#include "planner/coverage/predicted_loss.h"
#include "planner/geometry_follower.h"
#include "planner/planner.h"
#include "planner/refinement/exposure_graph.h"
#include "planner/refinement/pose_estimate.h"
#include "planner/refinement/surface_samples.h"
#include "planner/surface_distance.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// The complaint, or "accepted".
template <typename Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

CoverageOptions coverage_options() {
  CoverageOptions options;
  options.ideal_distance = 4;
  return options;
}

// A gallery of three slots with one view, and what is needed to compare it.
struct Compared {
  Compared() : camera(relief_camera({0, 0, 0}, {0, 0, 4})), gallery(3) {
    photograph = gallery.relief.photograph(camera);
    gallery.add(camera, photograph);
    visible = gallery.relief.visibility->trace(camera.shrunk_to(80));
  }
  Camera camera;
  Gallery gallery;
  Photograph photograph;
  VisibilityBuffer visible;
};

TEST_CASE("a pyramid refuses photographs without pixels, or without three values for each") {
  const Compared scene;
  Photograph cut = scene.photograph;
  cut.rgb.pop_back();
  CHECK(complaint([&] { Pyramid pyramid(cut); }) ==
        "pyramid: the size of photograph.rgb is 129599, must be three times the number of pixels, 129600");
  const Photograph narrow{0, 4, {}, {}}, low{4, 0, {}, {}};
  CHECK(complaint([&] { Pyramid pyramid(narrow); }) == "pyramid: photograph.width is 0, must be at least 1");
  CHECK(complaint([&] { Pyramid pyramid(low); }) == "pyramid: photograph.height is 0, must be at least 1");
  CHECK(complaint([&] { Pyramid pyramid(scene.photograph, 0); }) == "pyramid: coarsest_px is 0, must be at least 1");
  Pyramid pyramid(scene.photograph);
  Photograph other{120, 360, scene.photograph.rgb, {}};
  CHECK(complaint([&] { pyramid.refer_to(other); }) == "pyramid: the copy's width is 120, must be the photograph's");
  CHECK(complaint([&] { pyramid.refer_to(cut); }) ==
        "pyramid: the size of photograph.rgb is 129599, must be three times the number of pixels, 129600");
}

TEST_CASE("surface samples refuse images without pixels and buffers that are not filled") {
  const Compared scene;
  const Pyramid pyramid(scene.photograph);
  const auto samples = [&](const Camera& camera, const VisibilityBuffer& visible) {
    return complaint([&] { (void)choose_surface_samples(camera, pyramid, visible, 100); });
  };
  CHECK(samples(scene.camera, scene.visible) == "accepted");
  CHECK(samples(scene.camera.scaled_to(120, 180), scene.visible) ==
        "surface samples: camera.width is 120, must be the photograph's");
  CHECK(samples(scene.camera.scaled_to(240, 90), scene.visible) ==
        "surface samples: camera.height is 90, must be the photograph's");
  CHECK(samples(scene.camera, {}) == "surface samples: visible.width is 0, must be at least 1, and so the height");
  VisibilityBuffer cut = scene.visible;
  cut.depth.pop_back();
  CHECK(samples(scene.camera, cut) ==
        "surface samples: the size of visible.depth is 4799, must be the number of its pixels, 4800");
  cut = scene.visible;
  cut.face.pop_back();
  CHECK(samples(scene.camera, cut) ==
        "surface samples: the size of visible.face is 4799, must be the number of its pixels, 4800");
  CHECK(complaint([] { (void)sampling_px(0, 4); }) == "surface samples: photograph_px is 0, must be at least 1");
  CHECK(complaint([] { (void)sampling_px(4, 0); }) == "surface samples: most_px is 0, must be at least 1");
}

TEST_CASE(
    "median colours, trust masks, lens and pose estimates refuse views that are not the atlas's, and unknown faces") {
  Compared scene;
  const Pyramid pyramid(scene.photograph);
  const std::vector<SurfaceSample> samples = choose_surface_samples(scene.camera, pyramid, scene.visible, 100);
  std::vector<SurfaceSample> lost = samples;
  lost.back().face = FaceId(1u << 30);
  const std::span<const std::optional<ComparedView>> all(scene.gallery.views);
  const auto medians = [&](const Camera& camera, std::span<const SurfaceSample> points, std::size_t views) {
    return complaint(
        [&] { (void)median_colors(camera, pyramid, points, scene.gallery.atlas, all.first(views), std::nullopt); });
  };
  CHECK(medians(scene.camera, samples, 3) == "accepted");
  CHECK(medians(scene.camera, samples, 2) == "median colours: the size of views is 2, must be the atlas's capacity, 3");
  CHECK(medians(scene.camera.scaled_to(120, 180), samples, 3) ==
        "median colours: camera.width is 120, must be the photograph's");
  CHECK(medians(scene.camera, lost, 3).find("median colours: a sample's face is 1073741824, must be below") == 0);

  const auto trust = [&](const VisibilityBuffer& visible, std::size_t views, std::uint32_t grid_px) {
    TrustOptions options;
    options.grid_px = grid_px;
    return complaint([&] {
      (void)trust_mask(scene.camera, pyramid, glm::dvec3(1), visible, scene.gallery.atlas, all.first(views),
                       std::nullopt, options, TrustExtent::regions);
    });
  };
  CHECK(trust(scene.visible, 3, 80) == "accepted");
  CHECK(trust(scene.visible, 1, 80) == "trust: the size of views is 1, must be the atlas's capacity, 3");
  CHECK(trust(scene.visible, 3, 7) == "trust: grid_px is 7, must be at least 8");
  CHECK(trust({}, 3, 80) == "trust: visible.width is 0, must be at least 1, and so the height");

  const std::vector<Camera> given(3, scene.camera);
  const auto lenses = [&](std::size_t views, const std::vector<std::vector<SurfaceSample>>& points) {
    return complaint([&] { (void)estimate_lenses(scene.gallery.atlas, all.first(views), given, points); });
  };
  CHECK(lenses(3, {samples, {}, {}}) == "accepted");
  CHECK(lenses(2, {samples, {}, {}}) == "lenses: the size of views is 2, must be the atlas's capacity, 3");
  CHECK(lenses(3, {samples}) == "lenses: the size of samples is 1, must be the atlas's capacity, 3");
  CHECK(lenses(3, {lost, {}, {}}).find("lenses: a sample's face is 1073741824, must be below") == 0);
  const auto poses = [&](std::size_t views, const std::vector<std::vector<SurfaceSample>>& points) {
    return complaint([&] { (void)estimate_poses(scene.gallery.atlas, all.first(views), given, points); });
  };
  CHECK(poses(3, {samples, {}, {}}) == "accepted");
  CHECK(poses(2, {samples, {}, {}}) == "poses: the size of views is 2, must be the atlas's capacity, 3");
}

TEST_CASE("an exposure graph refuses slots that it does not have and ratios that are no numbers, and stays as it was") {
  ExposureGraph graph(2);
  const glm::dvec3 twice(std::log(2.0));
  graph.set(0, std::vector<ExposureRatio>{{1, twice, twice, 100}});
  const auto before = graph.solve(false);
  const auto set = [&](ViewSlot slot, const ExposureRatio& ratio) {
    return complaint([&] { graph.set(slot, std::vector<ExposureRatio>{ratio}); });
  };
  CHECK(set(2, {1, twice, twice, 1}) == "exposure graph: slot is 2, must be below the number of slots, 2");
  CHECK(set(0, {7, twice, twice, 1}) == "exposure graph: a ratio's slot is 7, must be below the number of slots, 2");
  CHECK(set(0, {1, {0, kNan, 0}, twice, 1}) == "exposure graph: log_ratio is nan, must be finite");
  CHECK(set(0, {1, twice, {0, 0, kNan}, 1}) == "exposure graph: log_luminance is nan, must be finite");
  CHECK(complaint([&] { graph.erase(2); }) == "exposure graph: slot is 2, must be below the number of slots, 2");
  CHECK(graph.solve(false) == before);
}

TEST_CASE("a coverage ledger refuses cells and slots that are not there, and options that break a rule") {
  const Relief relief;
  const auto cells = static_cast<std::uint32_t>(relief.surface->cells.cells.size());
  CoverageLedger ledger(*relief.surface, 2, coverage_options(), 0);
  const std::vector<CellPart> lost = {{CellId{cells}, {}}};
  const std::string no_cell = "coverage: a part's cell is " + std::to_string(cells) +
                              ", must be below the number of cells, " + std::to_string(cells);
  const std::string no_slot = "coverage: slot is 2, must be below the number of slots, 2";
  const std::vector<ViewSlot> two = {2};
  CHECK(complaint([&] { (void)ledger.gain(lost); }) == no_cell);
  CHECK(complaint([&] { ledger.add_demand(lost); }) == no_cell);
  CHECK(complaint([&] { ledger.remove_demand(lost); }) == no_cell);
  CHECK(complaint([&] { (void)ledger.weight(lost); }) == no_cell);
  CHECK(complaint([&] { (void)ledger.exchange_gains(lost, {}); }) == no_cell);
  CHECK(complaint([&] { (void)ledger.exchange_gains({}, two); }) == no_slot);
  CHECK(complaint([&] { (void)ledger.joint_exchange_gain(lost, {}); }) == no_cell);
  CHECK(complaint([&] { (void)ledger.joint_exchange_gain({}, two); }) == no_slot);
  CHECK(complaint([&] { ledger.insert(0, lost); }) == no_cell);
  CHECK(complaint([&] { ledger.insert(2, {}); }) == no_slot);
  CHECK(complaint([&] { ledger.erase(2); }) == no_slot);
  CHECK(complaint([&] {
          ledger.follow(*relief.surface, std::vector<CellId>(3));
        }).find("coverage: the size of previous_cell is 3, must be the number of cells") == 0);
  CHECK_FALSE(ledger.stored(0));
  CHECK(complaint([&] { CoverageLedger(*relief.surface, 2, CoverageOptions{}, 0); }) ==
        "coverage: ideal_distance is 0, must be finite and above 0");
}

TEST_CASE("coverage refuses counts and sizes that cannot be, and a gap that is no number") {
  const Relief relief;
  const Camera camera = relief_camera({0, 0, 0}, {0, 0, 4});
  const Cell& cell = relief.surface->cells.cells[0];
  const auto refused = [&](double size, double pixels) {
    return complaint([&] { (void)contribution(cell, size, camera, pixels, coverage_options()); });
  };
  CHECK(refused(1, 10) == "accepted");
  CHECK(refused(0, 10) == "coverage: cell_size is 0, must be finite and above 0");
  CHECK(refused(1, -1) == "coverage: visible_pixels is -1, must be finite and not negative");
  CHECK(refused(1, kNan) == "coverage: visible_pixels is nan, must be finite and not negative");
  CHECK(complaint([] { (void)novel_directions(0, true); }) == "coverage: count is 0, must be at least 1");
  CHECK(complaint([] { (void)predicted_loss_db(kNan); }) == "predicted loss: gap is nan, must be a number");
  CHECK(complaint([] { (void)predicted_reference_loss_db(kNan); }) == "predicted loss: gap is nan, must be a number");
}

struct PlannedRelief {
  explicit PlannedRelief(std::uint32_t slots = 3)
      : atlas(relief.surface, slots), planner(atlas, *relief.visibility, options()) {}
  static PlannerOptions options() {
    PlannerOptions options;
    options.coverage = coverage_options();
    options.min_view_gain = 0;
    return options;
  }
  Relief relief;
  Atlas atlas;
  Planner planner;
};

std::size_t cells_seen(const Atlas& atlas) {
  const std::vector<std::uint8_t> seen = atlas.snapshot().cell_seen;
  return static_cast<std::size_t>(std::count(seen.begin(), seen.end(), 1));
}

TEST_CASE("a planner refuses cameras that are none and photographs that lack pixels, and no trace of them is left") {
  PlannedRelief planned;
  const Camera camera = relief_camera({0, 0, 0}, {0, 0, 4});
  const Photograph photograph = planned.relief.photograph(camera);
  const double coverage = planned.planner.store().summed_coverage();
  const auto offer = [&](const Camera& at, const Photograph& of) {
    return complaint([&] { (void)planned.planner.offer("a", at, of); });
  };
  const auto keep = [&](const Camera& at, const Photograph& of) {
    return complaint([&] { (void)planned.planner.force_store("a", at, [&] { return of; }); });
  };
  Photograph cut = photograph;
  cut.rgb.resize(cut.rgb.size() - 3);
  CHECK(offer(camera, cut).find("129597") != std::string::npos);
  CHECK(keep(camera, cut).find("129597") != std::string::npos);
  Photograph half_valid = photograph;
  half_valid.valid.resize(100, 1);
  CHECK(offer(camera, half_valid).find("valid") != std::string::npos);
  CHECK(offer(camera.scaled_to(120, 90), photograph).find("accepted") == std::string::npos);
  Camera broken = camera;
  broken.fx = kNan;
  CHECK(offer(broken, photograph) == "camera: fx is nan, must be finite and positive");
  CHECK(keep(broken, photograph) == "camera: fx is nan, must be finite and positive");
  CHECK(complaint([&] { planned.planner.count_demand(broken); }) == "camera: fx is nan, must be finite and positive");
  CHECK(complaint([&] { (void)planned.planner.parts_of(broken); }) == "camera: fx is nan, must be finite and positive");
  CHECK(complaint([&] { (void)planned.planner.offer("a", camera, PhotographSource()); }) ==
        "planner: view a: there is no function for its photograph");
  CHECK(complaint([&] {
          (void)GeometryFollower(planned.planner).update_surface(nullptr, *planned.relief.visibility, {}, {});
        }) == "planner: surface is null");
  CHECK(complaint([&] { (void)median_surface_distance(std::vector{broken}, *planned.relief.visibility); }) ==
        "camera: fx is nan, must be finite and positive");
  const PhotographSource missing = []() -> Photograph { throw std::invalid_argument("no such file"); };
  CHECK(complaint([&] { (void)planned.planner.offer("a", camera, missing); }) == "no such file");
  CHECK(complaint([&] { (void)planned.planner.force_store("a", camera, missing); }) == "no such file");
  CHECK(planned.planner.store().summed_coverage() == coverage);
  CHECK(planned.atlas.size() == 0);
  CHECK(cells_seen(planned.atlas) == 0);
  CHECK(offer(camera, photograph) == "accepted");
  CHECK(cells_seen(planned.atlas) > 0);
}

TEST_CASE("a view that is promised a slot has seen nothing before its photograph is there") {
  PlannedRelief planned;
  const Camera camera = relief_camera({0, 0, 0}, {0, 0, 4});
  Verdict verdict = planned.planner.reserve("a", camera);
  REQUIRE(verdict.slot);
  CHECK(cells_seen(planned.atlas) == 0);
  const PhotographSource missing = []() -> Photograph { throw std::invalid_argument("no such file"); };
  CHECK(complaint([&] { planned.planner.store_reserved("a", missing, verdict); }) == "no such file");
  CHECK(cells_seen(planned.atlas) == 0);
  planned.planner.store_reserved(
      "a", [&] { return planned.relief.photograph(camera); }, verdict);
  CHECK(cells_seen(planned.atlas) > 0);
}

TEST_CASE("a refiner refuses slots without a view, and cameras that are not for each slot") {
  PlannedRelief planned(2);
  const Camera camera = relief_camera({0, 0, 0}, {0, 0, 4});
  const Photograph photograph = planned.relief.photograph(camera);
  planned.planner.offer("a", camera, photograph);
  Refiner refiner(planned.atlas, *planned.relief.visibility, {});
  CHECK(complaint([&] { refiner.add(2, camera, {}); }) ==
        "refinement: slot is 2, must be below the atlas's capacity, 2");
  CHECK(complaint([&] { refiner.add(1, camera, {}); }) == "refinement: slot is 1, must be one that holds a view");
  Refinement lost;
  lost.ratios.push_back({5, glm::dvec3(0), glm::dvec3(0), 1});
  CHECK(complaint([&] { refiner.add(0, camera, lost); }) ==
        "refinement: a ratio's slot is 5, must be below the atlas's capacity, 2");
  CHECK(complaint([&] { refiner.remove(2); }) == "refinement: slot is 2, must be below the atlas's capacity, 2");
  CHECK(complaint([&] { refiner.refresh(2); }) == "refinement: slot is 2, must be below the atlas's capacity, 2");
  CHECK(complaint([&] { (void)refiner.refine(camera.scaled_to(120, 90), photograph); }) != "accepted");
  Camera broken = camera;
  broken.fy = kNan;
  CHECK(complaint([&] { (void)refiner.refine(broken, photograph); }) ==
        "camera: fy is nan, must be finite and positive");
  LensEstimates estimates;
  const auto correct = [&](const Photograph& given) {
    return complaint([&] { refiner.correct_lenses(estimates, [&](auto, const auto&) { return given; }); });
  };
  CHECK(correct(photograph) == "refinement: the size of cameras is 0, must be the atlas's capacity, 2");
  refiner.add(0, camera, {});
  estimates.cameras = {camera.scaled_to(120, 90), {}};
  estimates.lenses.push_back({{1}, {}, {}, {}, 0, 0, true});
  CHECK(correct(photograph) == "refinement: a lens's slot is 1, must be one that holds a view");
  estimates.lenses[0].slots = {2};
  CHECK(correct(photograph) == "refinement: a lens's slot is 2, must be below the atlas's capacity, 2");
  estimates.lenses[0].slots = {0};
  CHECK(correct(photograph) != "accepted");
  estimates.cameras[0] = camera;
  CHECK(correct(Photograph{1, 1, {0, 0, 0}, {}}) != "accepted");
  CHECK(planned.atlas.view(0)->camera.width == 240);
}

Contribution sound_part() {
  return {{0, 0, 1}, 0.5, 4, 0.5, 0.1};
}

// Each field of a part with a value that breaks its rule, and what is said of it.
struct BadPart {
  Contribution part;
  std::string sentence;
};

std::vector<BadPart> bad_parts(const std::string& task) {
  std::vector<BadPart> bad(6, {sound_part(), task + ": a part's "});
  bad[0].part.direction = {0, 0, 2};
  bad[0].sentence = task + ": the length of a part's direction is 2, must be 1 or 0";
  bad[1].part.direction.x = kNan;
  bad[1].sentence = task + ": the length of a part's direction is nan, must be 1 or 0";
  bad[2].part.positional = -1;
  bad[2].sentence += "positional is -1, must be finite and not negative";
  bad[3].part.distance = std::numeric_limits<double>::infinity();
  bad[3].sentence += "distance is inf, must be finite and not negative";
  bad[4].part.cell_share = kNan;
  bad[4].sentence += "cell_share is nan, must be finite and not negative";
  bad[5].part.picture_share = 1.5;
  bad[5].sentence += "picture_share is 1.5, must be in [0, 1]";
  return bad;
}

TEST_CASE("every measure of coverage refuses cells, slots, parts and lists that are none of its own") {
  const Compared scene;
  const Surface& surface = *scene.gallery.relief.surface;
  const std::size_t cells = surface.cells.cells.size();
  CoverageOptions options = coverage_options();
  options.metric = GENERATE(CoverageOptions::Metric::directions, CoverageOptions::Metric::paper);
  const std::unique_ptr<CellCoverage> coverage = make_cell_coverage(surface, options, 0);
  REQUIRE(coverage->cells() == cells);
  const Contribution part = sound_part();
  coverage->insert(0, 3, part);
  const CellId beyond(static_cast<std::uint32_t>(cells));
  std::vector<double> four(4), three(3);
  const std::vector<std::uint8_t> victims(4), few(3);
  const std::string no_cell =
      "coverage: cell is " + std::to_string(cells) + ", must be below the number of cells, " + std::to_string(cells);
  const std::vector<ViewSlot> slots{3};
  CHECK(complaint([&] { (void)coverage->value(beyond); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->gain(beyond, part, {}, {}); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->value_by_definition(beyond, {}, nullptr); }) == no_cell);
  CHECK(complaint([&] { coverage->change_demand(beyond, part, DemandChange::add, four); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->weight(beyond); }) == no_cell);
  CHECK(complaint([&] { coverage->insert(beyond, 0, part); }) == no_cell);
  CHECK(complaint([&] { coverage->erase(beyond, 3); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->references(beyond); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->reference_losses(beyond); }) == no_cell);
  CHECK(complaint([&] { coverage->give_up(beyond, slots); }) == no_cell);
  CHECK(complaint([&] { (void)coverage->reference_service(beyond); }) == no_cell);

  const std::string too_short = " is 3, must be more than the largest slot of cell 0, 3";
  CHECK(complaint([&] { coverage->insert(0, 2, part, three); }) == "coverage: the size of losses" + too_short);
  CHECK(complaint([&] { coverage->erase(0, 3, three); }) == "coverage: the size of losses" + too_short);
  CHECK(complaint([&] { coverage->insert(1, 3, part, three); }) ==
        "coverage: slot is 3, must be below the size of losses, 3");
  CHECK(complaint([&] { coverage->change_demand(0, part, DemandChange::add, three); }) ==
        "coverage: the size of losses" + too_short);
  CHECK(complaint([&] { (void)coverage->gain(0, part, few, three); }) == "coverage: the size of victims" + too_short);
  CHECK(complaint([&] { (void)coverage->gain(0, part, victims, three); }) ==
        "coverage: the size of corrections is 3, must be that of victims, 4");
  CHECK(complaint([&] { coverage->insert(0, 3, part); }) == "coverage: slot is 3, must not be a member of cell 0 yet");
  CHECK(complaint([&] { coverage->insert(0, ViewSlot::none, part); }) ==
        "coverage: slot is 4294967295, must be below the largest number that is no slot, 4294967295");
  CHECK(complaint([&] { coverage->erase(0, 2); }) == "coverage: slot is 2, must be a member of cell 0");

  for (const auto& refused : bad_parts("coverage")) {
    const auto& bad = refused.part;
    const std::string& sentence = refused.sentence;
    CHECK(complaint([&] { (void)coverage->gain(0, bad, {}, {}); }) == sentence);
    CHECK(complaint([&] { coverage->change_demand(0, bad, DemandChange::add, {}); }) == sentence);
    CHECK(complaint([&] { coverage->insert(1, 0, bad); }) == sentence);
    CHECK(complaint([&] { (void)coverage->value_by_definition(0, {}, &bad); }) == sentence);
  }

  CHECK(complaint([&] { coverage->follow(surface, std::vector<CellId>(cells - 1, CellId::none)); }) ==
        "coverage: the size of previous_cell is " + std::to_string(cells - 1) + ", must be the number of cells, " +
            std::to_string(cells));
  CHECK(complaint([&] { coverage->follow(surface, std::vector<CellId>(cells, CellId{beyond})); }) ==
        "coverage: previous_cell is " + std::to_string(cells) + ", must be below the number of old cells, " +
            std::to_string(cells));
  // What was refused has changed nothing.
  CHECK(complaint([&] { coverage->erase(0, 3); }) == "accepted");
}

TEST_CASE("a measure of coverage refuses bad options and gains that are no bound") {
  const Compared scene;
  const Surface& surface = *scene.gallery.relief.surface;
  CoverageOptions options = coverage_options();
  options.metric = GENERATE(CoverageOptions::Metric::directions, CoverageOptions::Metric::paper);
  for (const double gain : {-1.0, kNan}) {
    CHECK_THAT(
        complaint([&] { (void)make_cell_coverage(surface, options, gain); }),
        Catch::StartsWith("coverage: min_reference_gain is ") && Catch::EndsWith(", must be finite and not negative"));
  }
  options.max_references = 0;
  CHECK_THAT(complaint([&] { (void)make_cell_coverage(surface, options, 0); }),
             Catch::Contains("max_references is 0, must be"));
  CHECK(complaint([&] { (void)tammes_cosine_bound(options); }) == "coverage: max_references is 0, must be at least 1");
}

TEST_CASE("demand refuses bad parts, parts that were not added, and priors that are none") {
  CellDemand demand;
  for (const auto& refused : bad_parts("coverage")) {
    const auto& bad = refused.part;
    const std::string& sentence = refused.sentence;
    CHECK(complaint([&] { demand.add(bad); }) == sentence);
  }
  CHECK(complaint([&] { demand.remove(sound_part()); }) == "demand: a part is removed that was not added");
  CHECK(complaint([&] { (void)demand.weight(-1); }) == "demand: prior is -1, must be finite and not negative");
  demand.add(sound_part());
  CHECK(complaint([&] { demand.remove(sound_part()); }) == "accepted");
}

TEST_CASE("coverage of what was offered refuses cells, stores and slots that are none of its own") {
  const Compared scene;
  const Surface& surface = *scene.gallery.relief.surface;
  const std::size_t cells = surface.cells.cells.size();
  OfferedCoverage offered(surface, coverage_options());
  const CoverageLedger store(surface, 2, coverage_options(), 0);
  const std::vector<CellPart> beyond{{CellId{static_cast<std::uint32_t>(cells)}, sound_part()}};
  const std::string no_cell = "coverage: a part's cell is " + std::to_string(cells) +
                              ", must be below the number of cells, " + std::to_string(cells);
  CHECK(complaint([&] { offered.add_demand(beyond); }) == no_cell);
  CHECK(complaint([&] { offered.remove_demand(beyond); }) == no_cell);
  CHECK(complaint([&] { offered.add(beyond); }) == no_cell);
  CHECK(complaint([&] { (void)offered.gap(store, beyond); }) == no_cell);
  for (const auto& refused : bad_parts("coverage")) {
    const auto& bad = refused.part;
    const std::string& sentence = refused.sentence;
    const std::vector<CellPart> parts{{0, bad}};
    CHECK(complaint([&] { offered.add(parts); }) == sentence);
  }
  CHECK(complaint([&] { (void)offered.gap_without(store, 2); }) ==
        "coverage: slot is 2, must be below the number of slots, 2");
  CHECK(complaint([&] { (void)offered.held(beyond[0].cell); }) ==
        "coverage: cell is " + std::to_string(cells) + ", must be below the number of cells, " + std::to_string(cells));
  Surface smaller = surface;
  smaller.cells.cells.resize(1);
  smaller.cells.cell_of_face.assign(smaller.cells.cell_of_face.size(), 0);
  const CoverageLedger other(smaller, 2, coverage_options(), 0);
  CHECK(complaint([&] { (void)offered.gap(other); }) ==
        "coverage: the size of store is 1, must be the number of cells, " + std::to_string(cells));
  CoverageOptions printed = coverage_options();
  printed.metric = CoverageOptions::Metric::paper;
  CHECK(complaint([&] { OfferedCoverage coverage(surface, printed); }) ==
        "coverage: metric is Metric::paper, must be Metric::directions for what was offered");
}

}  // namespace
}  // namespace lumatlas
