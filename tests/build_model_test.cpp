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

}  // namespace
}  // namespace lumatlas
