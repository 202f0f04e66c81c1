// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a job by its photographs and faces, fitted to measured jobs.
#pragma once

#include <vector>

namespace lumatlas {

struct CostSample {
  double photographs = 0, faces = 0;
  double cost = 0;  // >= 0
};

// cost = per_job + per_photograph * photographs + per_face * faces.
struct CostFit {
  double per_job = 0, per_photograph = 0, per_face = 0;  // each >= 0

  [[nodiscard]] double at(double photographs, double faces) const {
    return per_job + per_photograph * photographs + per_face * faces;
  }
};

// Returns the fit of least squares, of errors relative to the cost, among those without negative terms. Samples without
// cost do not count; of none the fit is 0. Terms that the samples cannot tell apart are left out, per_job first.
[[nodiscard]] CostFit fitted_cost(const std::vector<CostSample>& given);

}  // namespace lumatlas
