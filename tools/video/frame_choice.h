// SPDX-License-Identifier: GPL-3.0-or-later
// Chooses the frames of a video that become photographs.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "tools/video/video_frame.h"

namespace lumatlas {

// The largest step that leaves neighbours enough in common for their poses to be found.
inline constexpr double kLargestGoodStep = 0.35;

struct FrameChoiceOptions {
  // Movement of the picture from a chosen frame to the next one, as a share of its longer side, in (0, 1): neighbours
  // overlap by about the rest.
  double step = 0.1;
  double least_found_again = 0.2;  // share of corners below which a frame begins another take, in [0, 1)
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const FrameChoiceOptions& options);

// Returns how far the picture moves between two frames of one take, as a share of its longer side. It is the mean over
// the picture's parts of the sum of their motions, in which shaking to and fro cancels out and walking straight on does
// not.
[[nodiscard]] double motion_between(std::span<const VideoFrame> frames, std::size_t first, std::size_t last);

// Returns the indices of the chosen frames, ascending. Each is the sharpest frame of the stretch in which the picture
// has moved by two to four thirds of a step since the chosen frame before. The first of a take is the sharpest within
// its first third of a step. Throws std::invalid_argument for bad options.
[[nodiscard]] std::vector<std::size_t> choose_frames(std::span<const VideoFrame> frames,
                                                     const FrameChoiceOptions& options = {});

// Returns the smallest step, from options.step on, at which the videos together give at most `most` frames, or fewer
// than two each. Returns options.step where that gives few enough already. Throws std::invalid_argument for bad
// options.
[[nodiscard]] double step_for(std::span<const std::vector<VideoFrame>> videos, std::size_t most,
                              const FrameChoiceOptions& options = {});

// Leaves out frames, evenly, until all videos together have at most `most`, or two each if that is more. A step cannot
// make the frames fewer where a video has more cuts than that.
void leave_at_most(std::vector<std::vector<std::size_t>>& chosen, std::size_t most);

}  // namespace lumatlas
