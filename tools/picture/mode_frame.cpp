// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/mode_frame.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "planner/refinement/surface_deviation.h"
#include "tools/score/measures/counted_pixels.h"

namespace lumatlas {

namespace {

ModeFrame blank_frame(std::uint32_t width, std::uint32_t height, std::uint32_t channels) {
  const std::size_t pixels = std::size_t{width} * height;
  return {width, height, channels, std::vector<float>(pixels * channels, 0.0f),
          std::vector<PixelMark>(pixels, PixelMark::no_surface)};
}

PixelMark mark_of(PixelState state) {
  switch (state) {
    case PixelState::empty:
      return PixelMark::no_surface;
    case PixelState::unseen:
      return PixelMark::unseen;
    case PixelState::untextured:
      return PixelMark::untextured;
    case PixelState::textured:
      break;
  }
  return PixelMark::number;
}

PixelMark mark_of_cell(const Snapshot& snapshot, CellId cell) {
  if (snapshot.cell_seen[cell] == 0) return PixelMark::unseen;
  return snapshot.references.of_cell(cell).empty() ? PixelMark::untextured : PixelMark::number;
}

std::vector<std::string> channel_names(Mode mode) {
  if (mode == Mode::weights) return {"R", "G", "B"};
  if (mode == Mode::depth) return {"Z"};
  return {"Y"};
}

}  // namespace

ModeFrame cell_frame(const VisibilityBuffer& visible, const Snapshot& snapshot, std::span<const float> value_of_cell,
                     bool always) {
  if (value_of_cell.size() != snapshot.cell_seen.size()) {
    throw std::invalid_argument("cell frame: value_of_cell has " + std::to_string(value_of_cell.size()) +
                                " entries, must have one for each of the " + std::to_string(snapshot.cell_seen.size()) +
                                " cells");
  }
  ModeFrame frame = blank_frame(visible.width, visible.height, 1);
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    if (visible.face[pixel] == FaceId::none) continue;
    const CellId cell = snapshot.surface->cells.cell_of_face[visible.face[pixel]];
    frame.marks[pixel] = always ? PixelMark::number : mark_of_cell(snapshot, cell);
    if (frame.marks[pixel] == PixelMark::number) frame.values[pixel] = value_of_cell[cell];
  }
  return frame;
}

std::vector<float> reference_counts(const Snapshot& snapshot) {
  std::vector<float> counts(snapshot.cell_seen.size());
  for (std::size_t cell = 0; cell < counts.size(); ++cell) {
    counts[cell] = static_cast<float>(snapshot.references.of_cell(cell).size());
  }
  return counts;
}

ModeFrame depth_frame(const VisibilityBuffer& visible) {
  ModeFrame frame = blank_frame(visible.width, visible.height, 1);
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    if (visible.face[pixel] == FaceId::none) continue;
    frame.marks[pixel] = PixelMark::number;
    frame.values[pixel] = visible.depth[pixel];
  }
  return frame;
}

ModeFrame trust_frame(const VisibilityBuffer& visible, const Snapshot& snapshot, const Camera& camera) {
  ModeFrame frame = cell_frame(visible, snapshot, snapshot.cell_deviation, false);
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    if (frame.marks[pixel] != PixelMark::number) continue;
    const auto deviation = static_cast<double>(frame.values[pixel]);
    const auto depth = static_cast<double>(visible.depth[pixel]);
    frame.values[pixel] = static_cast<float>(shift_px(deviation, camera.fx, depth));
  }
  return frame;
}

ModeFrame diagnosis_frame(const Diagnosis& diagnosis, Mode mode) {
  if (mode != Mode::valid_views && mode != Mode::winner && mode != Mode::weights) {
    throw std::invalid_argument("diagnosis frame: mode must be valid_views, winner or weights");
  }
  ModeFrame frame = blank_frame(diagnosis.width, diagnosis.height, mode == Mode::weights ? 3 : 1);
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    frame.marks[pixel] = mark_of(diagnosis.state[pixel]);
    if (frame.marks[pixel] != PixelMark::number) continue;
    const PixelDiagnosis& told = diagnosis.pixels[pixel];
    if (mode == Mode::weights) {
      std::copy(told.shares.begin(), told.shares.end(), frame.values.begin() + static_cast<std::ptrdiff_t>(3 * pixel));
    } else {
      frame.values[pixel] = static_cast<float>(mode == Mode::winner ? told.winner : told.valid_views);
    }
  }
  return frame;
}

ModeFrame error_frame(const Photograph& rendering, const Photograph& photograph, std::span<const std::uint8_t> mask) {
  const CountedPixels counted = counted_pixels(rendering, photograph, mask);
  ModeFrame frame = blank_frame(photograph.width, photograph.height, 1);
  for (std::size_t pixel = 0; pixel < frame.marks.size(); ++pixel) {
    frame.marks[pixel] = counted[pixel] != 0 ? PixelMark::number : PixelMark::not_scored;
    if (counted[pixel] == 0) continue;
    double squares = 0;
    for (std::size_t value = 3 * pixel; value < 3 * pixel + 3; ++value) {
      const double difference = rendering.rgb[value] - photograph.rgb[value];
      squares += difference * difference;
    }
    frame.values[pixel] = static_cast<float>(std::sqrt(squares / 3));
  }
  return frame;
}

FloatImage float_image(const ModeFrame& frame, Mode mode) {
  FloatImage image{frame.width, frame.height, channel_names(mode), frame.values};
  for (std::size_t value = 0; value < image.values.size(); ++value) {
    if (frame.marks[value / frame.channels] == PixelMark::number) continue;
    image.values[value] = std::numeric_limits<float>::quiet_NaN();
  }
  return image;
}

}  // namespace lumatlas
