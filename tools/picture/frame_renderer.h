// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of `lumatlas render`: a picture, or what a mode shows in its place.
#pragma once

#include <memory>
#include <optional>

#include "atlas/atlas.h"
#include "atlas/images/float_image.h"
#include "blend/blend_options.h"
#include "blend/renderer.h"
#include "mesh/visibility/visibility.h"
#include "tools/frame/background.h"
#include "tools/picture/mode_picture.h"

namespace lumatlas {

struct FrameOptions {
  Mode mode = Mode::picture;
  BlendOptions blend;
  std::optional<ValueRange> range;  // the mode's range of colours; none: its own, see ModeColors
  bool color_bar = true;            // below a mode's picture
  Background background;            // for Mode::picture
};

// Returns whether the renderer draws a mode. The other modes cast rays alone and need no OpenGL.
[[nodiscard]] bool needs_renderer(Mode mode);

class FrameRenderer {
 public:
  // `renderer` has the snapshot loaded; null if the mode does not need it. Both must outlive this. Throws InputError
  // for Mode::coverage if the snapshot does not say how well its cells are covered, and what ModeColors throws.
  FrameRenderer(const Snapshot& snapshot, const FrameOptions& options, Renderer* renderer);

  // `photograph`: what Mode::error compares with, taken by the camera; null for every other mode.
  [[nodiscard]] SoftPicture picture(const Camera& camera, const Photograph* photograph);
  // For OpenEXR: linear light, or the mode's numbers as they are, NaN where there are none.
  [[nodiscard]] FloatImage numbers(const Camera& camera, const Photograph* photograph);

 private:
  [[nodiscard]] ModeFrame frame(const Camera& camera, const Photograph* photograph);
  [[nodiscard]] ModeFrame error(const Camera& camera, const Photograph& photograph);

  const Snapshot& snapshot_;
  FrameOptions options_;
  Renderer* renderer_;
  std::unique_ptr<Visibility> visibility_;  // null: the mode does without
  std::optional<ModeColors> colors_;        // none: Mode::picture
  std::vector<float> value_of_cell_;
};

}  // namespace lumatlas
