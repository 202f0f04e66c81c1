// SPDX-License-Identifier: GPL-3.0-or-later
// Poses of all views at once, from starts that are far off.
#include "planner/refinement/joint/joint_solver.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "planner/refinement/lens_estimate.h"
#include "planner/refinement/pose_estimate.h"
#include "tests/support/scenes/relief_scenes.h"

namespace lumatlas {
namespace {

// Views on an arc whose poses are wrong by `px` pixels.
struct DisturbedArc {
  DisturbedArc(double px, std::uint32_t seed) : gallery(kViews), samples(kViews) {
    for (std::uint32_t i = 0; i < kViews; ++i) {
      const Camera truth = camera_on_arc(3.0 * i - 12);
      given.push_back(disturbed(truth, px, kViews * seed + i, gallery.relief.points(truth, 12, 9)));
      gallery.add(given.back(), gallery.relief.photograph(truth));
    }
    for (std::uint32_t i = 0; i < kViews; ++i) {
      samples[i] = choose_surface_samples(given[i], gallery.views[i]->pyramid,
                                          gallery.relief.visibility->trace(given[i].shrunk_to(160)), 400);
    }
  }

  [[nodiscard]] JointInput input() const { return {gallery.atlas, gallery.views, given, samples}; }

  static constexpr std::uint32_t kViews = 9;
  Gallery gallery;
  std::vector<Camera> given;
  std::vector<std::vector<SurfaceSample>> samples;
};

TEST_CASE("no step is kept that makes the differences worse, also where the whole step of Gauss and Newton would") {
  constexpr std::array<std::uint32_t, 9> kFinest = {0, 0, 0, 0, 0, 0, 0, 0, 0};
  std::ptrdiff_t steps = 0, shortened = 0;
  for (std::uint32_t seed = 0; seed < 6; ++seed) {
    const DisturbedArc arc(12, seed);
    JointSolver solver(arc.input(), {{}, 400, kMostStepOperations, {}});
    solver.measure_noise();
    const double before = solver.held_out_residual();
    solver.refine(kFinest);
    for (const JointStep& step : solver.steps()) {
      CHECK(step.gain > 0);
      CHECK(step.coarser == 0);
    }
    steps += std::ssize(solver.steps());
    shortened += std::ranges::count_if(solver.steps(), [](const JointStep& step) { return step.damping > 0; });
    CHECK(solver.held_out_residual() < before);
  }
  CAPTURE(steps);
  CHECK(steps > 12);
  CHECK(shortened > 0);
}

TEST_CASE("the squares of the normal equations lie within the pattern that is known before") {
  const DisturbedArc arc(3, 1);
  const JointInput input = arc.input();
  const std::vector<std::size_t> lens_of(DisturbedArc::kViews, 0);
  const JointProblem problem(input.atlas, input.views, input.samples, lens_of, 400, {});
  JointState state;
  state.lens_parameters.assign(1, Block::Zero());
  state.cameras = arc.given;
  state.gain.assign(DisturbedArc::kViews, 1);
  state.motion.assign(DisturbedArc::kViews, Block::Zero());
  const bool with_motions = GENERATE(false, true);
  ViewBlocks block_of;
  std::size_t blocks = 1;
  for (std::size_t slot = 0; slot < DisturbedArc::kViews; ++slot) block_of.own.push_back(blocks++);
  for (std::size_t slot = 0; with_motions && slot < DisturbedArc::kViews; ++slot) block_of.motion.push_back(blocks++);
  const JointEquations equations =
      joint_equations(problem, state, problem.linearise(state, &ViewPart::points, 0, 0.02, true),
                      std::vector<Block>{Block::Ones()}, blocks, block_of, {});
  const BlockPattern pattern = joint_pattern(problem, blocks, block_of, {});
  REQUIRE(pattern.size() == blocks);
  std::size_t squares = 0;
  for (std::size_t column = 0; column < blocks; ++column) {
    CHECK(std::ranges::is_sorted(pattern[column]));
    for (const auto& [row, square] : equations.H.column(column)) {
      CHECK(std::ranges::binary_search(pattern[column], row));
      ++squares;
    }
  }
  CHECK(squares > blocks);
}

TEST_CASE("where a factor takes too much, poses are found step by step, and lenses are left alone") {
  const DisturbedArc arc(3, 1);
  const JointInput input = arc.input();
  const auto poses = [&](std::size_t most_operations) {
    return estimate_poses(input.atlas, input.views, input.given, input.samples, {.most_operations = most_operations});
  };
  const PoseEstimate factored = poses(kMostStepOperations), stepwise = poses(0);
  CHECK(stepwise.views == DisturbedArc::kViews);
  CHECK(stepwise.improves());
  CHECK(stepwise.residual_after == Approx(factored.residual_after).epsilon(0.01));
  for (std::size_t view = 0; view < DisturbedArc::kViews; ++view) {
    CAPTURE(view);
    CHECK(glm::distance(stepwise.cameras[view].center(), factored.cameras[view].center()) < 1e-3);
  }
  const auto lenses = [&](std::size_t most_operations) {
    return estimate_lenses(input.atlas, input.views, input.given, input.samples, {.most_operations = most_operations});
  };
  const LensEstimates refused = lenses(0);
  CHECK(refused.too_large);
  CHECK(refused.views == 0);
  CHECK_FALSE(refused.significant());
  CHECK_FALSE(refused.undecided());
  CHECK_FALSE(lenses(1).too_large);
}

}  // namespace
}  // namespace lumatlas
