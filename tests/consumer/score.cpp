// SPDX-License-Identifier: GPL-3.0-or-later
// The measures alone: a picture against itself and against one that is twice as bright.
#include <cmath>
#include <cstdio>

#include "tools/score/measures/scores.h"

int main() {
  using namespace lumatlas;
  Photograph photograph;
  photograph.width = 32;
  photograph.height = 32;
  for (int i = 0; i < 3 * 32 * 32; ++i) photograph.rgb.push_back(static_cast<std::uint8_t>(40 + i * 7 % 90));
  const Photograph brighter = apply_gain(photograph, 2);
  const RegionScores same = score_region(photograph, photograph, {}, {});
  const RegionScores darker = score_region(photograph, brighter, {}, {});
  std::printf("the same: %.1f dB; half as bright: %.1f dB raw, %.1f dB fitted by a gain of %.3f\n", same.raw.psnr,
              darker.raw.psnr, darker.fitted.psnr, darker.gain);
  return std::isinf(same.raw.psnr) && darker.raw.psnr < darker.fitted.psnr && std::abs(darker.gain - 2) < 0.05 ? 0 : 1;
}
