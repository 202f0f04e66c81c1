// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/surface/completion_gain.h"

#include <cmath>
#include <cstddef>

#include "tools/base/process/interrupt.h"
#include "tools/pipeline/surface/frame_prediction.h"

namespace lumatlas {

namespace {

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
