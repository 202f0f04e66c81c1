// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/mode_picture.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesh/base/median.h"
#include "tools/picture/stored_depths.h"
#include "tools/score/report/error_picture.h"

namespace lumatlas {

namespace {

constexpr Rgb8 kNoSurface = {236, 236, 236};
constexpr Rgb8 kUnseen = {0, 0, 0};
constexpr Rgb8 kUntextured = {140, 140, 140};

// Finer than 8-bit colours on the ramps.
constexpr std::size_t kRampSteps = 1024;

// Pixels: where the colours of Mode::trust end.
constexpr double kMostShownShift = 6;

// More names than this are no help.
constexpr std::size_t kMostNames = 12;

const char* title_of(Mode mode) {
  switch (mode) {
    case Mode::coverage:
      return "coverage of the cell";
    case Mode::references:
      return "references of the cell (views)";
    case Mode::valid_views:
      return "valid views at the pixel";
    case Mode::winner:
      return "view that weighs most";
    case Mode::weights:
      return "share in the pixel (0 - 1) of";
    case Mode::trust:
      return "shift by the error of the surface (pixels)";
    case Mode::cells:
      return "cells, a colour each";
    case Mode::depth:
      return "depth z (scene units)";
    case Mode::error:
      return "error (8-bit sRGB levels)";
    case Mode::picture:
      break;
  }
  throw std::invalid_argument("mode colours: a picture has none");
}

double most_of(const std::vector<float>& values) {
  return values.empty() ? 0 : static_cast<double>(*std::max_element(values.begin(), values.end()));
}

double far_depth(const Snapshot& snapshot) {
  constexpr double kShare = 0.98;
  std::vector<double> depths = sampled_depths(snapshot);
  return depths.empty() ? 1 : percentile(std::move(depths), kShare);
}

ValueRange own_range(const Snapshot& snapshot, Mode mode) {
  switch (mode) {
    case Mode::coverage:
      return {0, std::max(1.0, most_of(snapshot.cell_coverage))};
    case Mode::references:
    case Mode::valid_views:
      return {0, std::max(1.0, most_of(reference_counts(snapshot)))};
    case Mode::trust:
      return {0, kMostShownShift};
    case Mode::depth:
      return {0, far_depth(snapshot)};
    default:
      return {0, kErrorFullScale};
  }
}

bool counts(Mode mode) {
  return mode == Mode::references || mode == Mode::valid_views;
}

std::vector<NamedColor> names_of(const Snapshot& snapshot, Mode mode) {
  std::vector<NamedColor> names;
  if (mode == Mode::weights) {
    names = {{{255, 0, 0}, "red: best view"}, {{0, 255, 0}, "green: second"}, {{0, 0, 255}, "blue: third"}};
  }
  if (mode == Mode::winner && snapshot.views.size() <= kMostNames) {
    for (ViewSlot slot{0}; slot < snapshot.views.size(); ++slot) {
      if (snapshot.views[slot]) names.push_back({distinct_color(slot), snapshot.views[slot]->name});
    }
  }
  if (mode == Mode::error) {
    names.push_back({kNotScoredColor, "not scored"});
    return names;
  }
  names.push_back({kNoSurface, "no surface"});
  if (mode == Mode::cells || mode == Mode::depth) return names;
  names.push_back({kUnseen, "never seen"});
  names.push_back({kUntextured, "seen, not textured"});
  return names;
}

Rgb8 color_of_mark(PixelMark mark) {
  switch (mark) {
    case PixelMark::unseen:
      return kUnseen;
    case PixelMark::untextured:
      return kUntextured;
    case PixelMark::not_scored:
      return kNotScoredColor;
    default:
      return kNoSurface;
  }
}

std::uint8_t byte_of_share(float share) {
  return static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0f, 1.0f)));
}

}  // namespace

bool has_range(Mode mode) {
  return mode == Mode::coverage || mode == Mode::trust || mode == Mode::depth || mode == Mode::error || counts(mode);
}

ModeColors::ModeColors(const Snapshot& snapshot, Mode mode, const std::optional<ValueRange>& range)
    : mode_(mode), bar_{title_of(mode), std::nullopt, names_of(snapshot, mode)} {
  if (range && !has_range(mode)) throw std::invalid_argument("mode colours: this mode has no range");
  if (!has_range(mode)) {
    if (mode == Mode::winner && snapshot.views.size() > kMostNames) {
      bar_.title += ", of " + std::to_string(snapshot.views.size());
    }
    return;
  }
  const ValueRange shown = range.value_or(own_range(snapshot, mode));
  if (!(std::isfinite(shown.least) && std::isfinite(shown.most) && shown.least < shown.most)) {
    throw std::invalid_argument("mode colours: the range goes from " + std::to_string(shown.least) + " to " +
                                std::to_string(shown.most) + ", must be finite and ascending");
  }
  const bool open = range || mode == Mode::trust || mode == Mode::depth || mode == Mode::error;
  const auto ramp = mode == Mode::error ? error_ramp : quantity_ramp;
  for (std::size_t i = 0; i < kRampSteps; ++i) {
    ramp_.push_back(ramp(static_cast<double>(i) / static_cast<double>(kRampSteps - 1)));
  }
  bar_.scale = ColorScale{shown.least, shown.most, ramp, counts(mode), open};
}

Rgb8 ModeColors::color(const float* values) const {
  if (mode_ == Mode::weights) return {byte_of_share(values[0]), byte_of_share(values[1]), byte_of_share(values[2])};
  if (!bar_.scale) return distinct_color(static_cast<std::uint32_t>(*values));
  const ColorScale& scale = *bar_.scale;
  const double part = std::clamp((static_cast<double>(*values) - scale.least) / (scale.most - scale.least), 0.0, 1.0);
  return ramp_[static_cast<std::size_t>(std::lround(part * static_cast<double>(kRampSteps - 1)))];
}

Photograph ModeColors::paint(const ModeFrame& frame) const {
  Photograph picture;
  picture.width = frame.width;
  picture.height = frame.height;
  picture.rgb.resize(3 * frame.marks.size());
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    const Rgb8 shown = frame.marks[pixel] == PixelMark::number ? color(&frame.values[pixel * frame.channels])
                                                               : color_of_mark(frame.marks[pixel]);
    std::copy(shown.begin(), shown.end(), picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
  }
  return picture;
}

}  // namespace lumatlas
