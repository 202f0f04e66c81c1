// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers that JSON has no notation for, and scores.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "tools/score/measures/scores.h"

namespace lumatlas {

// Itself if it is finite, null otherwise: no value.
[[nodiscard]] nlohmann::json json_number(double value);

// {"psnr", "ssim"}; the infinite PSNR of identical pictures is kPsnrOfIdentical, so that scripts can compare and
// average it like any other, and null always means that there was nothing to score.
[[nodiscard]] nlohmann::json json_scores(const Scores& scores);

// "raw", "fitted", "aligned" if measured, "textured", of the pixels of the mesh; the same of whole frames in "frame".
[[nodiscard]] nlohmann::json json_scores(const MethodScores& scores);
// In both places also "gain", "pixels", and "aligned_pixels" if measured.
[[nodiscard]] nlohmann::json json_scores(const ViewScores& scores);

}  // namespace lumatlas
