// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/frame_motion.h"

#include <catch2/catch.hpp>
#include <stdexcept>

#include "tests/tools/video/textured_wall.h"

namespace lumatlas {
namespace {

constexpr std::uint32_t kWidth = 320, kHeight = 240;

TEST_CASE("the motion of a wall is measured in shares of the longer side, in every part of the picture") {
  const TexturedWall wall(1);
  FrameMotion motion;
  const VideoFrame first = motion.next(wall.grey(kWidth, kHeight, 100, 100), kWidth, kHeight);
  CHECK(first.found_again == 1);
  CHECK(first.flow[0] == glm::vec2(0));
  CHECK(first.sharpness > 0);
  const VideoFrame second = motion.next(wall.grey(kWidth, kHeight, 106.5, 97), kWidth, kHeight);
  CHECK(second.found_again > 0.8);
  for (const glm::vec2& flow : second.flow) {
    CHECK(flow.x == Approx(-6.5 / kWidth).margin(0.3 / kWidth));
    CHECK(flow.y == Approx(3.0 / kWidth).margin(0.3 / kWidth));
  }
}

TEST_CASE("a blurred frame is less sharp, and of another view little is found again") {
  const TexturedWall wall(1), other(2);
  FrameMotion motion;
  const VideoFrame sharp = motion.next(wall.grey(kWidth, kHeight, 50, 50), kWidth, kHeight);
  std::vector<std::uint8_t> blurred(kWidth * kHeight, 0);
  constexpr int kSteps = 12;
  std::vector<double> sums(blurred.size(), 0);
  for (int step = 0; step < kSteps; ++step) {
    const std::vector<std::uint8_t> moved = wall.grey(kWidth, kHeight, 50 + step, 50);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += moved[i];
  }
  for (std::size_t i = 0; i < sums.size(); ++i) blurred[i] = static_cast<std::uint8_t>(sums[i] / kSteps);
  CHECK(motion.next(blurred, kWidth, kHeight).sharpness < 0.7 * sharp.sharpness);
  CHECK(motion.next(other.grey(kWidth, kHeight, 50, 50), kWidth, kHeight).found_again < 0.2);
  CHECK(motion.next(other.grey(kHeight, kWidth, 50, 50), kHeight, kWidth).found_again == 0);
}

TEST_CASE("frames without corners move by nothing") {
  FrameMotion motion;
  const std::vector<std::uint8_t> plain(kWidth * kHeight, 90);
  (void)motion.next(plain, kWidth, kHeight);
  const VideoFrame frame = motion.next(plain, kWidth, kHeight);
  CHECK(frame.found_again == 1);
  CHECK(frame.sharpness == 0);
  CHECK(frame.flow[5] == glm::vec2(0));
  CHECK_THROWS_AS(motion.next(plain, kWidth + 1, kHeight), std::invalid_argument);
  CHECK_THROWS_AS(motion.next({}, 0, 0), std::invalid_argument);
}

}  // namespace
}  // namespace lumatlas
