// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/frame_choice.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <optional>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr Requirement frame_choice_requires{"choice of frames"};

using Displacements = std::array<glm::dvec2, kFlowParts>;

// Adds how far the parts of `frame` have moved, and returns the mean length of the sums.
double add_motion(const VideoFrame& frame, Displacements& moved) {
  double sum = 0;
  for (std::size_t part = 0; part < kFlowParts; ++part) {
    moved[part] += glm::dvec2(frame.flow[part]);
    sum += glm::length(moved[part]);
  }
  return sum / static_cast<double>(kFlowParts);
}

// Chooses frames of one take, [first, end).
class Take {
 public:
  Take(std::span<const VideoFrame> frames, std::size_t first, std::size_t end, double step)
      : frames_(frames), first_(first), end_(end), step_(step) {}

  void choose(std::vector<std::size_t>& chosen) const {
    std::size_t last = sharpest_up_to(first_, first_, step_ / 3);
    chosen.push_back(last);
    while (const std::optional<std::size_t> begin = first_beyond(last, 2 * step_ / 3)) {
      last = sharpest_up_to(last, *begin, 4 * step_ / 3);
      chosen.push_back(last);
    }
  }

 private:
  // Returns the first frame after `origin` that has moved by that much since then.
  [[nodiscard]] std::optional<std::size_t> first_beyond(std::size_t origin, double motion) const {
    Displacements moved{};
    for (std::size_t i = origin + 1; i < end_; ++i) {
      if (add_motion(frames_[i], moved) >= motion) return i;
    }
    return std::nullopt;
  }

  // Returns the sharpest frame from `begin` on until one has moved by more than `motion` since `origin`.
  [[nodiscard]] std::size_t sharpest_up_to(std::size_t origin, std::size_t begin, double motion) const {
    Displacements moved{};
    std::size_t best = begin;
    for (std::size_t i = origin + 1; i < end_; ++i) {
      const double so_far = add_motion(frames_[i], moved);
      if (i <= begin) continue;
      if (so_far > motion) break;
      if (frames_[i].sharpness > frames_[best].sharpness) best = i;
    }
    return best;
  }

  std::span<const VideoFrame> frames_;
  std::size_t first_, end_;
  double step_;
};

std::size_t count_of(std::span<const std::vector<VideoFrame>> videos, const FrameChoiceOptions& options) {
  std::size_t count = 0;
  for (const std::vector<VideoFrame>& video : videos) count += choose_frames(video, options).size();
  return count;
}

// Returns the number of frames that all videos may have together, if `most` are asked for: each keeps at least two.
std::size_t most_of(std::size_t videos, std::size_t most) {
  return std::max(most, 2 * videos);
}

}  // namespace

void check(const FrameChoiceOptions& options) {
  frame_choice_requires(options.step > 0 && options.step < 1, "step", options.step, "in (0, 1)");
  frame_choice_requires(options.least_found_again >= 0 && options.least_found_again < 1, "least_found_again",
                        options.least_found_again, "in [0, 1)");
}

double motion_between(std::span<const VideoFrame> frames, std::size_t first, std::size_t last) {
  Displacements moved{};
  double motion = 0;
  for (std::size_t i = first + 1; i <= last; ++i) motion = add_motion(frames[i], moved);
  return motion;
}

std::vector<std::size_t> choose_frames(std::span<const VideoFrame> frames, const FrameChoiceOptions& options) {
  check(options);
  std::vector<std::size_t> chosen;
  for (std::size_t first = 0; first < frames.size();) {
    std::size_t end = first + 1;
    while (end < frames.size() && frames[end].found_again >= options.least_found_again) ++end;
    Take(frames, first, end, options.step).choose(chosen);
    first = end;
  }
  return chosen;
}

double step_for(std::span<const std::vector<VideoFrame>> videos, std::size_t most, const FrameChoiceOptions& options) {
  check(options);
  constexpr double kFactor = 1.05, kLargest = 0.99;
  FrameChoiceOptions wider = options;
  while (count_of(videos, wider) > most_of(videos.size(), most) && wider.step < kLargest) {
    wider.step = std::min(wider.step * kFactor, kLargest);
  }
  return wider.step;
}

void leave_at_most(std::vector<std::vector<std::size_t>>& chosen, std::size_t most) {
  std::size_t all = 0, place = 0;
  for (const std::vector<std::size_t>& of_video : chosen) all += of_video.size();
  const std::size_t left = most_of(chosen.size(), most);
  if (all <= left) return;
  for (std::vector<std::size_t>& of_video : chosen) {
    std::erase_if(of_video, [&](std::size_t) {
      const std::size_t before = place++ * left / all;
      return place * left / all == before;
    });
  }
}

}  // namespace lumatlas
