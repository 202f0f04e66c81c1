// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/frame_choice.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

namespace lumatlas {
namespace {

// Frames whose whole content moves by `flow` from each to the next, of one sharpness.
std::vector<VideoFrame> panned_frames(std::size_t count, glm::vec2 flow) {
  VideoFrame frame{1, 1, {}};
  frame.flow.fill(flow);
  return std::vector<VideoFrame>(count, frame);
}

// Frames of a camera that walks straight on: content moves outwards from the middle.
std::vector<VideoFrame> approaching_frames(std::size_t count, float speed) {
  VideoFrame frame{1, 1, {}};
  for (std::size_t part = 0; part < kFlowParts; ++part) {
    const std::size_t row = part / kFlowColumns, column = part % kFlowColumns;
    frame.flow[part] = speed * glm::vec2(static_cast<float>(column) - 1.5F, static_cast<float>(row) - 1.5F);
  }
  return std::vector<VideoFrame>(count, frame);
}

TEST_CASE("neighbours among the chosen frames of a pan are about a step apart") {
  const std::vector<VideoFrame> frames = panned_frames(400, {0.006F, 0.008F});  // 1 % a frame
  const std::vector<std::size_t> chosen = choose_frames(frames, {0.1, 0.2});
  REQUIRE(chosen.size() > 10);
  CHECK(chosen.front() == 0);
  for (std::size_t i = 1; i < chosen.size(); ++i) {
    const double moved = motion_between(frames, chosen[i - 1], chosen[i]);
    CHECK(moved >= 0.2 / 3 - 1e-6);
    CHECK(moved <= 0.4 / 3 + 1e-6);
  }
  CHECK(motion_between(frames, chosen.back(), frames.size() - 1) < 0.2 / 3);
}

TEST_CASE("of each stretch the sharpest frame is chosen") {
  std::vector<VideoFrame> frames = panned_frames(300, {0.01F, 0});
  for (std::size_t i = 0; i < frames.size(); ++i) frames[i].sharpness = i % 9 == 4 ? 5 : 1;
  const std::vector<std::size_t> chosen = choose_frames(frames, {0.12, 0.2});
  REQUIRE(chosen.size() > 20);
  for (const std::size_t index : chosen) CHECK(frames[index].sharpness == 5);
}

TEST_CASE("shaking gives no frames, and walking straight on does") {
  std::vector<VideoFrame> shaking = panned_frames(500, {0.02F, 0});
  for (std::size_t i = 0; i < shaking.size(); i += 2) shaking[i].flow.fill({-0.02F, 0});
  CHECK(choose_frames(shaking).size() == 1);
  CHECK(choose_frames(panned_frames(500, {0, 0})).size() == 1);
  const std::vector<VideoFrame> approaching = approaching_frames(100, 0.01F);
  CHECK(choose_frames(approaching).size() >= 8);
}

TEST_CASE("a cut begins another take") {
  std::vector<VideoFrame> frames = panned_frames(60, {0, 0});
  frames[20].found_again = 0.1;
  frames[45].found_again = 0;
  CHECK(choose_frames(frames) == std::vector<std::size_t>{0, 20, 45});
  CHECK(choose_frames({}).empty());
}

TEST_CASE("where fewer frames are asked for, all videos get a larger step") {
  const std::vector<std::vector<VideoFrame>> videos{panned_frames(500, {0.01F, 0}), panned_frames(900, {0, 0.01F})};
  CHECK(step_for(videos, 1000) == FrameChoiceOptions().step);
  const double step = step_for(videos, 60);
  CHECK(step > FrameChoiceOptions().step);
  std::size_t count = 0;
  for (const std::vector<VideoFrame>& video : videos) count += choose_frames(video, {step, 0.2}).size();
  CHECK(count <= 60);
  CHECK(count > 50);
  // Each video keeps a pair.
  CHECK(choose_frames(videos[0], {step_for(videos, 1), 0.2}).size() >= 2);
}

// A damaged video may seem to have a cut at each frame.
TEST_CASE("where a video has more cuts than frames are asked for, frames are left out evenly") {
  std::vector<VideoFrame> cuts = panned_frames(100, {0, 0});
  for (VideoFrame& frame : cuts) frame.found_again = 0;
  const std::vector<std::vector<VideoFrame>> videos{cuts, panned_frames(50, {0, 0}), cuts};
  const double step = step_for(videos, 20);
  std::vector<std::vector<std::size_t>> chosen;
  for (const std::vector<VideoFrame>& video : videos) chosen.push_back(choose_frames(video, {step, 0.2}));
  CHECK(chosen[0].size() + chosen[1].size() + chosen[2].size() == 201);
  leave_at_most(chosen, 20);
  CHECK(chosen[0].size() + chosen[1].size() + chosen[2].size() == 20);
  CHECK(chosen[0].size() >= 9);
  CHECK(chosen[2].size() >= 9);
  CHECK(chosen[0][1] - chosen[0][0] == 10);
  std::vector<std::vector<std::size_t>> few{{0, 4}, {7}};
  leave_at_most(few, 3);
  CHECK(few == std::vector<std::vector<std::size_t>>{{0, 4}, {7}});
}

TEST_CASE("options of the choice of frames are checked") {
  const std::vector<VideoFrame> frames = panned_frames(3, {0, 0});
  CHECK_THROWS_AS(choose_frames(frames, {0, 0.2}), std::invalid_argument);
  CHECK_THROWS_AS(choose_frames(frames, {NAN, 0.2}), std::invalid_argument);
  CHECK_THROWS_AS(choose_frames(frames, {0.1, 1}), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
