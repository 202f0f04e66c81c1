// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace lumatlas {

// In the mean over photographs; below 0: the pictures are better than before.
struct MeasuredLoss {
  double mean_db = 0;   // PSNR
  double error_db = 0;  // standard error of the mean, >= 0
  double ssim = 0;      // structural similarity; also 0 if it was not measured
  // Returns a bound that the true loss seldom exceeds.
  [[nodiscard]] double at_most_db() const { return mean_db + error_db; }
};

}  // namespace lumatlas
