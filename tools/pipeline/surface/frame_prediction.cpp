// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/frame_prediction.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

#include "tools/base/process/interrupt.h"
#include "tools/frame/background.h"
#include "tools/scene/for_each_index.h"

namespace lumatlas {

namespace {

constexpr double kSameDepth = 0.03;       // share of a point's depth by which another view's surface may be off
constexpr std::size_t kNearest = 3;       // photographs that a prediction is the mean of, as pictures blend three
constexpr std::uint32_t kSampleStep = 3;  // pixels between the points that the surface's error is taken from
constexpr double kLeastError = 1;         // squared levels: 8-bit colours are no more exact

SurfaceError surface_error(const std::vector<FrameLook>& looks, std::size_t own) {
  const FrameLook& look = looks[own];
  double sum = 0, count = 0;
  glm::vec3 shown(0), predicted(0);
  for (std::uint32_t y = kSampleStep / 2; y < look.visible.height; y += kSampleStep) {
    for (std::uint32_t x = kSampleStep / 2; x < look.visible.width; x += kSampleStep) {
      const std::size_t pixel = std::size_t{y} * look.visible.width + x;
      if (look.photograph.valid[pixel] == 0 || !look.sees_surface(pixel)) continue;
      const std::optional<glm::vec3> color = predicted_color(looks, own, pixel);
      if (!color) continue;
      sum += squared_error(*color, look.photograph.color[pixel]);
      ++count;
      shown += look.photograph.color[pixel];
      predicted += *color;
    }
  }
  if (count == 0) return {};
  const float brightness = predicted.x + predicted.y + predicted.z;
  return {std::max(sum / count, kLeastError), brightness > 0 ? (shown.x + shown.y + shown.z) / brightness : 1};
}

// Returns the photograph as a picture that shows only what `shown` says, and the fill around it.
Photograph filled_picture(const SmallPhotograph& photograph, const std::vector<PixelState>& shown) {
  Rendering rendering{{photograph.camera.width, photograph.camera.height, {}, {}}, shown};
  rendering.picture.rgb.reserve(3 * photograph.color.size());
  for (const glm::vec3& color : photograph.color) {
    for (int channel = 0; channel < 3; ++channel) {
      rendering.picture.rgb.push_back(static_cast<std::uint8_t>(std::clamp(color[channel] + 0.5F, 0.0F, 255.0F)));
    }
  }
  return with_background(rendering, {}).picture;
}

FrameError frame_error(const std::vector<FrameLook>& looks, std::size_t own, const Visibility* far) {
  const FrameLook& look = looks[own];
  FrameError result;
  result.surface = surface_error(looks, own);
  const VisibilityBuffer beyond = far != nullptr ? far->trace(look.photograph.camera) : VisibilityBuffer();
  std::vector<PixelState> shown(look.visible.face.size(), PixelState::empty);
  for (std::size_t pixel = 0; pixel < shown.size(); ++pixel) {
    if (look.photograph.valid[pixel] == 0) continue;
    if (look.sees_surface(pixel) || (far != nullptr && beyond.face[pixel] != FaceId::none)) {
      shown[pixel] = PixelState::textured;
      ++result.shown;
    } else {
      result.lacking.push_back(pixel);
    }
  }
  if (result.lacking.empty()) return result;
  const Photograph filled = filled_picture(look.photograph, shown);
  for (const std::size_t pixel : result.lacking) {
    const std::uint8_t* const rgb = &filled.rgb[3 * pixel];
    result.filled.push_back(squared_error({rgb[0], rgb[1], rgb[2]}, look.photograph.color[pixel]));
  }
  return result;
}

// Photographs that cannot be compared with others get the mean of those that can; false: none can.
bool give_all_a_surface_error(std::vector<FrameError>& frames) {
  double sum = 0, count = 0;
  for (const FrameError& frame : frames) {
    if (std::isnan(frame.surface.mean)) continue;
    sum += frame.surface.mean;
    ++count;
  }
  for (FrameError& frame : frames) {
    if (count > 0 && std::isnan(frame.surface.mean)) frame.surface.mean = sum / count;
  }
  return count > 0;
}

}  // namespace

FrameLook::FrameLook(const SmallPhotograph& small, VisibilityBuffer buffer)
    : photograph(small), center(small.camera.center()), visible(std::move(buffer)) {}

FrameLook::FrameLook(const SmallPhotograph& small, const Visibility& mesh)
    : FrameLook(small, mesh.trace(small.camera)) {}

glm::dvec3 FrameLook::point_at(std::size_t pixel) const {
  const std::size_t x = pixel % visible.width, y = pixel / visible.width;
  const glm::dvec2 middle(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
  return center + double{visible.depth[pixel]} * photograph.camera.ray(middle);
}

const glm::vec3* FrameLook::color_of(const glm::dvec3& point) const {
  const glm::dvec3 cam = photograph.camera.cam_from_world(point);
  if (!(cam.z > 0)) return nullptr;
  const glm::dvec2 at = photograph.camera.image_from_cam(cam);
  if (!(at.x >= 0 && at.y >= 0 && at.x < visible.width && at.y < visible.height)) return nullptr;
  const std::size_t pixel = static_cast<std::size_t>(at.y) * visible.width + static_cast<std::size_t>(at.x);
  if (photograph.valid[pixel] == 0 || !sees_surface(pixel)) return nullptr;
  return std::abs(double{visible.depth[pixel]} - cam.z) <= kSameDepth * cam.z ? &photograph.color[pixel] : nullptr;
}

std::vector<FrameLook> frame_looks_at(const std::vector<SmallPhotograph>& photographs, const Visibility& mesh) {
  std::vector<FrameLook> looks;
  looks.reserve(photographs.size());
  for (const SmallPhotograph& photograph : photographs) {
    throw_if_interrupted();
    looks.emplace_back(photograph, mesh);
  }
  return looks;
}

double squared_error(const glm::vec3& a, const glm::vec3& b) {
  const glm::dvec3 difference = glm::dvec3(a) - glm::dvec3(b);
  return glm::dot(difference, difference) / 3;
}

std::optional<glm::vec3> predicted_color(const std::vector<FrameLook>& looks, std::size_t own, std::size_t pixel) {
  const glm::dvec3 point = looks[own].point_at(pixel);
  const glm::dvec3 direction = glm::normalize(point - looks[own].center);
  std::array<std::pair<double, const glm::vec3*>, kNearest> best{};  // descending by cosine
  for (std::size_t other = 0; other < looks.size(); ++other) {
    if (other == own) continue;
    const glm::vec3* const color = looks[other].color_of(point);
    if (color == nullptr) continue;
    std::pair<double, const glm::vec3*> next(glm::dot(glm::normalize(point - looks[other].center), direction), color);
    for (auto& entry : best) {
      if (entry.second == nullptr || next.first > entry.first) std::swap(entry, next);
      if (next.second == nullptr) break;
    }
  }
  glm::vec3 sum(0);
  float count = 0;
  for (const auto& [cosine, color] : best) {
    if (color == nullptr) break;
    sum += *color;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

std::optional<std::vector<FrameError>> frame_errors(const std::vector<FrameLook>& looks, const Visibility* far) {
  std::vector<FrameError> frames(looks.size());
  for_each_index(looks.size(), [&](std::size_t own) {
    throw_if_interrupted();
    frames[own] = frame_error(looks, own, far);
  });
  if (!give_all_a_surface_error(frames)) return std::nullopt;
  return frames;
}

}  // namespace lumatlas
