// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/cluster/cost_fit.h"

#include <catch2/catch.hpp>
#include <vector>

namespace lumatlas {
namespace {

std::vector<CostSample> samples_of(const CostFit& fit) {
  std::vector<CostSample> samples;
  for (const double photographs : {10.0, 40.0, 90.0}) {
    for (const double faces : {1e5, 3e5, 4e5}) samples.push_back({photographs, faces, fit.at(photographs, faces)});
  }
  return samples;
}

TEST_CASE("costs that are linear are found again, with and without each term") {
  for (const CostFit& truth : {CostFit{2, 0.1, 1e-5}, CostFit{0, 0.1, 1e-5}, CostFit{2, 0, 1e-5}, CostFit{2, 0.1, 0},
                               CostFit{3, 0, 0}, CostFit{0, 0, 2e-5}}) {
    const CostFit found = fitted_cost(samples_of(truth));
    CHECK(found.per_job == Approx(truth.per_job).margin(1e-6));
    CHECK(found.per_photograph == Approx(truth.per_photograph).margin(1e-8));
    CHECK(found.per_face == Approx(truth.per_face).margin(1e-12));
  }
}

TEST_CASE("no term of a fit is negative, and errors count relative to the cost") {
  // A line through the two would have -1 a job.
  const CostFit steep = fitted_cost({{0, 1, 1}, {0, 2, 3}});
  CHECK(steep.per_job == 0);
  // Least squares of k * 1 / 1 - 1 and k * 2 / 3 - 1: k = (1 + 2 / 3) / (1 + 4 / 9).
  CHECK(steep.per_face == Approx(15.0 / 13));
}

TEST_CASE("terms that the samples cannot tell apart are left out, and jobs without cost do not count") {
  const CostFit found = fitted_cost({{10, 1000, 5}, {20, 2000, 10}, {0, 0, 0}});
  CHECK(found.per_photograph == Approx(0.5));
  CHECK(found.per_face == 0);
  CHECK(found.per_job == 0);
  CHECK(fitted_cost({}).at(100, 1e6) == 0);
}

}  // namespace
}  // namespace lumatlas
