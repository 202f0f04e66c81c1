// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/completion_gain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
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

// A small photograph and its visibility buffer of a mesh.
struct FrameLook {
  const SmallPhotograph& photograph;
  glm::dvec3 center;
  VisibilityBuffer visible;

  FrameLook(const SmallPhotograph& small, const Visibility& mesh)
      : photograph(small), center(small.camera.center()), visible(mesh.trace(small.camera)) {}

  [[nodiscard]] bool sees_surface(std::size_t pixel) const { return visible.face[pixel] != FaceId::none; }
  [[nodiscard]] glm::dvec3 point_at(std::size_t pixel) const {
    const std::size_t x = pixel % visible.width, y = pixel / visible.width;
    const glm::dvec2 middle(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5);
    return center + double{visible.depth[pixel]} * photograph.camera.ray(middle);
  }
  // Returns the colour of a point of the surface; null if the photograph does not show it.
  [[nodiscard]] const glm::vec3* color_of(const glm::dvec3& point) const {
    const glm::dvec3 cam = photograph.camera.cam_from_world(point);
    if (!(cam.z > 0)) return nullptr;
    const glm::dvec2 at = photograph.camera.image_from_cam(cam);
    if (!(at.x >= 0 && at.y >= 0 && at.x < visible.width && at.y < visible.height)) return nullptr;
    const std::size_t pixel = static_cast<std::size_t>(at.y) * visible.width + static_cast<std::size_t>(at.x);
    if (photograph.valid[pixel] == 0 || !sees_surface(pixel)) return nullptr;
    return std::abs(double{visible.depth[pixel]} - cam.z) <= kSameDepth * cam.z ? &photograph.color[pixel] : nullptr;
  }
};

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

// Returns the colour of a pixel of looks[own] as the other photographs predict it; none if they do not show it.
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

// The error with which the other photographs predict the surface that one sees.
struct SurfaceError {
  double mean = std::numeric_limits<double>::quiet_NaN();  // squared error; NaN: no other photograph shows the same
  float gain = 1;  // brightness of the photograph, as a multiple of that of its prediction
};

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

// The errors of one photograph's pixels.
struct FrameError {
  SurfaceError surface;
  double shown = 0;                  // number of pixels that see a surface or what is far
  std::vector<std::size_t> lacking;  // the pixels that see neither
  std::vector<double> filled;        // squared error of the fill at each of these

  [[nodiscard]] double shown_sum() const { return surface.mean * shown; }
  [[nodiscard]] double filled_sum() const { return std::accumulate(filled.begin(), filled.end(), 0.0); }
};

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

std::optional<std::vector<FrameError>> frame_errors(const std::vector<FrameLook>& looks, const Visibility* far) {
  std::vector<FrameError> frames(looks.size());
  for_each_index(looks.size(), [&](std::size_t own) {
    throw_if_interrupted();
    frames[own] = frame_error(looks, own, far);
  });
  if (!give_all_a_surface_error(frames)) return std::nullopt;
  return frames;
}

// Returns the sum of the squared errors of the pixels that lack a surface in the given mesh, once it is completed.
// `looks` are those at the completed mesh. The fill has the photograph's own brightness, so the prediction gets it too.
double completed_sum(const std::vector<FrameLook>& looks, std::size_t own, const FrameError& frame) {
  double sum = 0;
  for (std::size_t i = 0; i < frame.lacking.size(); ++i) {
    const std::size_t pixel = frame.lacking[i];
    std::optional<glm::vec3> color;
    if (looks[own].sees_surface(pixel)) color = predicted_color(looks, own, pixel);
    sum += color ? squared_error(frame.surface.gain * *color, looks[own].photograph.color[pixel]) : frame.filled[i];
  }
  return sum;
}

// The mean over all photographs of the growth of PSNR, in dB, from errors `before` to `after`.
class MeanGain {
 public:
  void add(double before, double after) {
    if (!(before > 0 && after > 0)) return;  // a photograph without a valid pixel
    sum_ += 10 * std::log10(before / after);
    ++count_;
  }
  [[nodiscard]] double value() const { return count_ > 0 ? sum_ / count_ : 0; }

 private:
  double sum_ = 0, count_ = 0;
};

}  // namespace

std::optional<double> largest_gain_db(const std::vector<SmallPhotograph>& photographs, const Visibility& given,
                                      const Visibility* far) {
  const std::optional<std::vector<FrameError>> frames = frame_errors(frame_looks_at(photographs, given), far);
  if (!frames) return std::nullopt;
  MeanGain gain;
  for (const FrameError& frame : *frames) gain.add(frame.shown_sum() + frame.filled_sum(), frame.shown_sum());
  return gain.value();
}

std::optional<double> completion_gain_db(const std::vector<SmallPhotograph>& photographs, const Visibility& given,
                                         const Visibility* far, const Visibility& completed) {
  const std::optional<std::vector<FrameError>> frames = frame_errors(frame_looks_at(photographs, given), far);
  if (!frames) return std::nullopt;
  const std::vector<FrameLook> looks = frame_looks_at(photographs, completed);
  MeanGain gain;
  for (std::size_t own = 0; own < looks.size(); ++own) {
    throw_if_interrupted();
    const FrameError& frame = (*frames)[own];
    gain.add(frame.shown_sum() + frame.filled_sum(), frame.shown_sum() + completed_sum(looks, own, frame));
  }
  return gain.value();
}

}  // namespace lumatlas
