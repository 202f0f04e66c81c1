// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/diagnosis/view_flow.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <stdexcept>
#include <vector>

#include "mesh/base/median.h"
#include "planner/refinement/photometry.h"
#include "tests/support/refusal.h"
#include "tests/support/scenes/painted_wall.h"
#include "tools/lab/diagnosis/flow_summary.h"

namespace lumatlas {
namespace {

ViewFlowOptions few_patches() {
  ViewFlowOptions options;
  options.patches_per_view = 1000;
  options.patch.radius_px = 5;
  return options;
}

template <typename Value>
double middle(const ViewFlow& flow, const Value& value) {
  std::vector<double> values;
  for (const FlowOfPatch& patch : flow.flows) values.push_back(value(patch));
  return percentile(values, 0.5);
}

TEST_CASE("photographs of an exact surface from exact cameras do not flow") {
  const ViewFlow flow = view_flow(photographed(wall_before(0), speckled), few_patches());
  CHECK(flow.shown > 400);
  CHECK(flow.flows.size() > flow.shown / 2);
  CHECK(flow_summary(flow).length < 0.05);
  CHECK(flow_summary(flow).length_p90 < 0.15);
}

TEST_CASE("a surface that stands off flows along epipolar lines, as far as it is off") {
  for (const double before : {0.05, 0.1, -0.1}) {
    CAPTURE(before);
    const ViewFlow flow = view_flow(photographed(wall_before(before), speckled), few_patches());
    REQUIRE(flow.flows.size() > 200);
    const std::vector<Camera> cameras = cameras_before_wall();
    const double off = middle(flow, [&](const FlowOfPatch& patch) {
      const Camera &first = cameras[patch.first], &second = cameras[patch.second];
      const glm::dvec3 ray = first.ray(patch.image);
      const auto seen = [&](double depth) {
        const glm::dvec3 point = first.center() + (depth - first.center().z) / ray.z * ray;
        return second.image_from_cam(second.cam_from_world(point));
      };
      return glm::length(patch.move - (seen(kWallDepth) - seen(kWallDepth - before)));
    });
    CHECK(off < 0.1);
    const FlowSummary summary = flow_summary(flow);
    const double expected = cameras[0].fx * std::sin(glm::radians(8.0)) * std::abs(before) / kWallDepth;
    CHECK(summary.along == Approx(expected).epsilon(0.1));
    CHECK(summary.across < 0.1);
    CHECK(summary.along_share > 0.95);
    // The surface is nearer than what is shown if it stands before it.
    CHECK(std::signbit(middle(flow, [](const FlowOfPatch& patch) { return patch.along; })) == (before > 0));
  }
}

TEST_CASE("a camera that is turned at right angles to its way flows across epipolar lines, and not locally") {
  std::vector<Camera> noted = cameras_before_wall();
  const double turn = 0.01;  // radians: 2 pixels
  noted[1] = moved(noted[1], {turn, 0, 0}, glm::dvec3(0));
  const ViewFlow flow = view_flow(photographed(wall_before(0), {speckled, speckled, speckled}, noted), few_patches());
  const FlowSummary summary = flow_summary(flow);
  CHECK(summary.across == Approx(turn * noted[1].fx).epsilon(0.1));
  CHECK(summary.along < 0.2);
  CHECK(summary.along_share < 0.05);
  CHECK(summary.local < 0.1);
  const std::vector<FlowSummary> views = flow_summaries_by_view(flow);
  REQUIRE(views.size() == 3);
  std::size_t patches = 0;
  for (const FlowSummary& view : views) {
    CHECK(view.across == Approx(turn * noted[1].fx).epsilon(0.1));  // each is compared with the middle one, or it is it
    patches += view.patches;
  }
  CHECK(patches == summary.patches);
}

TEST_CASE("patches without texture, with edges of one direction, or of something else do not count") {
  const WallPaint stripes = [](double x, double /*y*/) { return 128 + 100 * std::sin(x / 0.1); };
  CHECK(view_flow(photographed(wall_before(0), grey), few_patches()).flows.empty());
  CHECK(view_flow(photographed(wall_before(0), stripes), few_patches()).flows.empty());
  std::vector<WallPaint> paints;
  for (const double shift : {0.0, 31.3, 77.7}) {
    paints.emplace_back([shift](double x, double y) { return speckled(x + shift, y - 2 * shift); });
  }
  const ViewFlow other = view_flow(photographed(wall_before(0), paints), few_patches());
  CHECK(other.shown > 400);
  CHECK(other.flows.size() < other.shown / 50);
}

TEST_CASE("a single photograph, and none, have nothing to flow to") {
  const ViewFlow flow = view_flow(photographed(wall_before(0), std::vector<WallPaint>{speckled}), few_patches());
  CHECK(flow.shown == 0);
  const FlowSummary summary = flow_summary(flow);
  CHECK(summary.patches == 0);
  CHECK(std::isnan(summary.length));
  CHECK(std::isnan(summary.along_share));
  CHECK(view_flow(Atlas(wall_before(0), 1).snapshot()).flows.empty());
}

TEST_CASE("a brighter photograph does not flow") {
  const WallPaint dark = [](double x, double y) { return 20 + 0.4 * speckled(x, y); };
  const ViewFlow flow = view_flow(photographed(wall_before(0), {speckled, dark, speckled}), few_patches());
  CHECK(flow.flows.size() > 200);
  CHECK(flow_summary(flow).length < 0.1);
}

TEST_CASE("flows are the same for any number of threads, and a cancel check ends the search") {
  const Snapshot snapshot = photographed(wall_before(0.05), speckled);
  ViewFlowOptions options = few_patches();
  const ViewFlow several = view_flow(snapshot, options);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const ViewFlow alone = view_flow(snapshot, options);
    CHECK(std::equal(alone.flows.begin(), alone.flows.end(), several.flows.begin(), several.flows.end(),
                     [](const FlowOfPatch& a, const FlowOfPatch& b) {
                       return a.first == b.first && a.second == b.second && a.image == b.image && a.move == b.move;
                     }));
  }
  options.cancel_check = [] { throw std::runtime_error("enough"); };
  CHECK_THROWS_WITH(view_flow(snapshot, options), "enough");
}

TEST_CASE("a move, a turn and a scale of a photograph are not local, what differs from patch to patch is") {
  ViewFlow smooth;
  for (int i = 0; i < 100; ++i) {
    const glm::dvec2 image(20 * (i % 10), 20 * (i / 10));
    const glm::dvec2 move = glm::dvec2(2, -1) + 0.01 * image + 0.005 * glm::dvec2(-image.y, image.x);
    smooth.flows.push_back({ViewSlot(0), ViewSlot(1), image, move, move.x, move.y});
  }
  smooth.shown = 200;
  CHECK(flow_summary(smooth).counting_share == 0.5);
  CHECK(flow_summary(smooth).length > 1);
  CHECK(flow_summary(smooth).local < 0.001);
  ViewFlow uneven = smooth;
  for (std::size_t i = 0; i < uneven.flows.size(); ++i) uneven.flows[i].move.x += i % 2 == 0 ? 0.5 : -0.5;
  CHECK(flow_summary(uneven).local == Approx(0.5).epsilon(0.2));
}

TEST_CASE("options of flows are refused by name") {
  const auto refused = [](const auto& change) { return refusal<ViewFlowOptions>(change); };
  CHECK_THAT(refused([](auto& o) { o.patches_per_view = 0; }), Catch::Contains("patches_per_view is 0"));
  CHECK_THAT(refused([](auto& o) { o.least_angle_deg = 0; }), Catch::Contains("least_angle_deg is 0"));
  CHECK_THAT(refused([](auto& o) { o.patch.radius_px = 1; }), Catch::Contains("radius_px is 1"));
  CHECK_THAT(refused([](auto& o) { o.patch.levels = 0; }), Catch::Contains("levels is 0"));
  CHECK_THAT(refused([](auto& o) { o.patch.most_px = 0; }), Catch::Contains("most_px is 0"));
  CHECK_THAT(refused([](auto& o) { o.patch.least_correlation = 2; }), Catch::Contains("least_correlation is 2"));
  CHECK_THAT(refused([](auto& o) { o.patch.most_deviation_px = 0; }), Catch::Contains("most_deviation_px is 0"));
}

}  // namespace
}  // namespace lumatlas
