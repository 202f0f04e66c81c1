// SPDX-License-Identifier: GPL-3.0-or-later
// Poses of all views at once, from starts that are far off.
#include "planner/refinement/joint_solver.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "tests/support/relief_scenes.h"

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
    JointSolver solver(arc.input(), {{}, 400, {}});
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

}  // namespace
}  // namespace lumatlas
