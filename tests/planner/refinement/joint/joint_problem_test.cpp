// SPDX-License-Identifier: GPL-3.0-or-later
// How the stored views disagree at surface points, on views whose true poses are known.
#include "planner/refinement/joint/joint_problem.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "planner/refinement/photometry.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

// Views on an arc, with the points at which each is compared with the others.
struct ComparedArc {
  explicit ComparedArc(const std::vector<double>& degrees)
      : gallery(static_cast<std::uint32_t>(degrees.size())), samples(degrees.size()) {
    for (const double angle : degrees) {
      given.push_back(camera_on_arc(angle));
      gallery.add(given.back(), gallery.relief.photograph(given.back()));
    }
    for (std::size_t i = 0; i < degrees.size(); ++i) {
      const Pyramid& pyramid = gallery.views[i]->pyramid;
      samples[i] =
          choose_surface_samples(given[i], pyramid, gallery.relief.visibility->trace(given[i].shrunk_to(160)), 400);
    }
  }

  [[nodiscard]] JointProblem problem() const {
    return {gallery.atlas, gallery.views, samples, std::vector<std::size_t>(given.size(), 0), 400, {}};
  }
  [[nodiscard]] JointState state() const {
    return {
        {Block::Zero()}, given, std::vector<double>(given.size(), 1), std::vector<Block>(given.size(), Block::Zero())};
  }

  Gallery gallery;
  std::vector<Camera> given;
  std::vector<std::vector<SurfaceSample>> samples;
};

TEST_CASE("a view that has turned away from a point has no part in its median") {
  const ComparedArc arc({-4, 0, 4});
  const JointProblem problem = arc.problem();
  JointState state = arc.state();
  const Linearised all = problem.linearise(state, &ViewPart::points, 0, 1, false)[0];
  REQUIRE(all.r.size() > 300);
  CHECK(all.r.cwiseAbs().maxCoeff() < 0.05);  // exact poses: what is left is the pixels'
  Camera& turned = state.cameras[2];
  for (int row : {0, 2}) {
    for (int axis = 0; axis < 3; ++axis) turned.cam_from_world_rotation[axis][row] *= -1;
    turned.cam_from_world_translation[row] *= -1;
  }
  CHECK(turned.cam_from_world(glm::dvec3(0, 0, 4)).z < 0);
  const Linearised behind = problem.linearise(state, &ViewPart::points, 0, 1, false)[0];
  CHECK(behind.r.cwiseAbs().maxCoeff() < 0.05);
  for (const std::array<TargetTerm, 2>& terms : behind.terms) {
    REQUIRE((terms[0].slot != 2 && terms[1].slot != 2));
  }
  // A view that looks beside the wall shows none of the points either.
  state.cameras[2] = arc.given[2];
  state.cameras[2].cam_from_world_translation.x += 100;
  const Linearised beside = problem.linearise(state, &ViewPart::points, 0, 1, false)[0];
  CHECK(beside.r.cwiseAbs().maxCoeff() < 0.05);
}

TEST_CASE("a point that no other view shows any more counts as an outlier") {
  const ComparedArc arc({-4, 4});
  JointState state = arc.state();
  state.cameras[1].cam_from_world_translation.x += 100;
  const Linearised alone = arc.problem().linearise(state, &ViewPart::points, 0, 1, true)[0];
  REQUIRE(alone.r.size() > 300);
  CHECK((alone.r.array() == tukey(kTukeyCutoff).value).all());
}

TEST_CASE("the derivatives by a motion are those by the pose, times when the line is read") {
  const ComparedArc arc({-4, 0, 4});
  const JointProblem problem = arc.problem();
  JointState state = arc.state();
  state.motion[1] << 0.004, -0.003, 0.002, 0.003, 0.002, -0.001, 0;
  const double depth = problem.parts()[1].depth;
  const auto seen = [&](const JointState& at, const glm::dvec3& position) {
    const Camera& camera = at.cameras[1];
    return camera.image_from_cam(when_read(motion_of(at.motion[1], depth), camera, camera.cam_from_world(position)));
  };
  constexpr double kStep = 1e-6;
  for (const glm::dvec3 position : {glm::dvec3(0.5, 0.6, 4), glm::dvec3(-0.7, -0.4, 4.1)}) {
    const ImageDerivatives derivatives = problem.derivatives(state, ViewSlot(1), position);
    CHECK(std::abs(derivatives.time) > 0.05);
    for (int i = 0; i < kPose; ++i) {
      CAPTURE(i);
      JointState more = state;
      more.motion[1][i] += kStep;
      const glm::dvec2 slope = (seen(more, position) - seen(state, position)) / kStep;
      const double scale = 5 + std::hypot(slope.x, slope.y);
      CHECK(std::abs(slope.x - derivatives.time * derivatives.by_own(0, i)) < 0.02 * scale);
      CHECK(std::abs(slope.y - derivatives.time * derivatives.by_own(1, i)) < 0.02 * scale);
    }
  }
}

}  // namespace
}  // namespace lumatlas
