// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/frame_motion.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/base/median.h"

namespace lumatlas {

namespace {

// A corner of the frame before and where it lies in this one.
struct FoundCorner {
  cv::Point2f before, now;
};

double laplacian_variance(const cv::Mat& grey) {
  cv::Mat laplacian;
  cv::Laplacian(grey, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation);
  return deviation[0] * deviation[0];
}

std::vector<cv::Point2f> corners_of(const cv::Mat& grey) {
  constexpr int kMost = 400;
  constexpr double kQuality = 0.01, kApart = 0.02;
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(grey, corners, kMost, kQuality, kApart * std::max(grey.cols, grey.rows));
  return corners;
}

// Follows the corners forth and back; those that do not return to where they were are not found again.
std::vector<FoundCorner> follow(const cv::Mat& before, const cv::Mat& now, const std::vector<cv::Point2f>& corners) {
  constexpr float kReturns = 1;  // pixel
  std::vector<cv::Point2f> there, back;
  std::vector<std::uint8_t> found, found_back;
  std::vector<float> errors;
  cv::calcOpticalFlowPyrLK(before, now, corners, there, found, errors);
  cv::calcOpticalFlowPyrLK(now, before, there, back, found_back, errors);
  std::vector<FoundCorner> result;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const cv::Point2f off = back[i] - corners[i];
    if (found[i] == 0 || found_back[i] == 0 || std::hypot(off.x, off.y) > kReturns) continue;
    result.push_back({corners[i], there[i]});
  }
  return result;
}

// The median of how far the corners have moved, in pixels.
glm::vec2 median_motion(const std::vector<FoundCorner>& corners) {
  std::vector<float> x, y;
  for (const FoundCorner& corner : corners) {
    x.push_back(corner.now.x - corner.before.x);
    y.push_back(corner.now.y - corner.before.y);
  }
  return {upper_median(x), upper_median(y)};
}

std::size_t part_of(const cv::Point2f& point, const cv::Size& size) {
  const auto index = [](float at, int extent, std::size_t parts) {
    const double share = std::clamp(static_cast<double>(at) / extent, 0.0, 1.0);
    return std::min(static_cast<std::size_t>(share * static_cast<double>(parts)), parts - 1);
  };
  return index(point.y, size.height, kFlowRows) * kFlowColumns + index(point.x, size.width, kFlowColumns);
}

// A part without enough corners moves as the whole picture does.
void set_flow(const std::vector<FoundCorner>& corners, const cv::Size& size, VideoFrame& frame) {
  constexpr std::size_t kEnough = 3;
  if (corners.empty()) return;
  std::array<std::vector<FoundCorner>, kFlowParts> parts;
  for (const FoundCorner& corner : corners) parts[part_of(corner.before, size)].push_back(corner);
  const glm::vec2 whole = median_motion(corners);
  const auto longer = static_cast<float>(std::max(size.width, size.height));
  for (std::size_t part = 0; part < kFlowParts; ++part) {
    frame.flow[part] = (parts[part].size() >= kEnough ? median_motion(parts[part]) : whole) / longer;
  }
}

}  // namespace

struct FrameMotion::State {
  cv::Mat before;
  std::vector<cv::Point2f> corners;
};

FrameMotion::FrameMotion() : state_(std::make_unique<State>()) {}
FrameMotion::~FrameMotion() = default;

VideoFrame FrameMotion::next(std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height) {
  if (width == 0 || height == 0 || grey.size() != std::size_t{width} * height) {
    throw std::invalid_argument("frame: has " + std::to_string(grey.size()) + " grey values, must have " +
                                std::to_string(width) + " x " + std::to_string(height) + ", at least one");
  }
  cv::Mat now(static_cast<int>(height), static_cast<int>(width), CV_8U);
  std::copy(grey.begin(), grey.end(), now.begin<std::uint8_t>());
  VideoFrame frame;
  frame.sharpness = laplacian_variance(now);
  const bool is_first = state_->before.empty();
  if (!is_first && state_->before.size() != now.size()) {
    frame.found_again = 0;
  } else if (!is_first && !state_->corners.empty()) {
    const std::vector<FoundCorner> found = follow(state_->before, now, state_->corners);
    frame.found_again = static_cast<double>(found.size()) / static_cast<double>(state_->corners.size());
    set_flow(found, now.size(), frame);
  }
  state_->corners = corners_of(now);
  state_->before = std::move(now);
  return frame;
}

}  // namespace lumatlas
