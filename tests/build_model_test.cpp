// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/build_model.h"

#include <catch2/catch.hpp>
#include <limits>
#include <stdexcept>

#include "mesh/errors.h"

namespace lumatlas {
namespace {

TEST_CASE("options that break a rule are refused before anything is read") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto complaint = [](const BuildOptions& options) -> std::string {
    try {
      (void)build_model("/nowhere", options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  BuildOptions options;
  CHECK_THROWS_AS(build_model("/nowhere", options), InputError);  // good options: only the scene is missing
  options.planner.coverage.ideal_distance = kNan;
  CHECK(complaint(options) == "coverage: ideal_distance is nan, must be finite and above 0");
  options = {};
  options.planner.min_view_gain = kNan;
  CHECK(complaint(options) == "planner: min_view_gain is nan, must be finite and not negative");
  options = {};
  options.cells.size = std::numeric_limits<double>::infinity();
  CHECK(complaint(options) == "cells: size is inf, must be finite and not negative");
  options = {};
  options.max_views = 0;
  CHECK(complaint(options) == "build: max_views is 0, must be at least 1");
  options = {};
  options.hold_out = HoldOut{1, 1};
  CHECK(complaint(options) == "hold is 1, must be at least 2");
}

TEST_CASE("what the photographs say about intrinsics is one sentence, and none if it is not significant") {
  IntrinsicsEstimate estimate;
  estimate.correction = {1.008, {-1.25, 0.5}, -0.0123};
  estimate.residual_before = 0.043;
  estimate.residual_after = 0.041;
  estimate.corner_px = 2.6;
  CHECK(intrinsics_advice(estimate, false).empty());
  estimate.significant = true;
  const std::string says =
      "The photographs agree better with a focal length 0.80 % longer, the principal point moved by (-1.2, 0.5) px and "
      "a radial coefficient of -0.0123 (a corner moves 2.6 px; residual 0.0430 -> 0.0410): ";
  CHECK(intrinsics_advice(estimate, false) ==
        says + "refine the cameras in the structure-from-motion program, or give --refine-intrinsics.");
  CHECK(intrinsics_advice(estimate, true) ==
        says +
            "focal length and principal point were applied, the radial coefficient was not, because the photographs "
            "would have to be undistorted again.");
}

}  // namespace
}  // namespace lumatlas
