// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/frame_renderer.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "blend/tables/tiles.h"
#include "mesh/base/errors.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

namespace {

bool needs_visibility(Mode mode) {
  return !needs_renderer(mode) || mode == Mode::error;
}

std::vector<float> values_of_cells(const Snapshot& snapshot, Mode mode) {
  if (mode == Mode::references) return reference_counts(snapshot);
  if (mode == Mode::trust && snapshot.cell_deviation.empty()) {
    throw InputError(
        "the model does not say how far its surface is off: it was built with surface.exact=on, or no two "
        "of its photographs show the same part from directions a few degrees apart");
  }
  if (mode == Mode::coverage) {
    if (snapshot.cell_coverage.empty()) {
      throw InputError("the model does not say how well its cells are covered: build it again for --mode coverage");
    }
    return snapshot.cell_coverage;
  }
  std::vector<float> numbers(snapshot.cell_seen.size());
  std::iota(numbers.begin(), numbers.end(), 0.0f);
  return numbers;
}

}  // namespace

bool needs_renderer(Mode mode) {
  return mode != Mode::coverage && mode != Mode::references && mode != Mode::trust && mode != Mode::cells &&
         mode != Mode::depth;
}

FrameRenderer::FrameRenderer(const Snapshot& snapshot, const FrameOptions& options, Renderer* renderer)
    : snapshot_(snapshot), options_(options), renderer_(renderer) {
  value_of_cell_ = values_of_cells(snapshot, options.mode);
  if (options.mode != Mode::picture) colors_.emplace(snapshot, options.mode, options.range);
  if (needs_visibility(options.mode)) visibility_ = make_ray_visibility(near_surface(*snapshot.surface).mesh);
}

// Scored as `lumatlas validate` scores its fitted figure.
ModeFrame FrameRenderer::error(const Camera& camera, const Photograph& photograph) {
  const VisibilityBuffer visible = visibility_->trace(camera);
  std::vector<std::uint8_t> mask(visible.face.size());
  std::transform(visible.face.begin(), visible.face.end(), mask.begin(),
                 [](std::uint32_t face) { return static_cast<std::uint8_t>(face != FaceId::none); });
  const Photograph rendering = render_tiled(*renderer_, camera, options_.blend).picture;
  return error_frame(apply_gain(rendering, fit_gain(rendering, photograph, mask)), photograph, mask);
}

ModeFrame FrameRenderer::frame(const Camera& camera, const Photograph* photograph) {
  switch (options_.mode) {
    case Mode::depth:
      return depth_frame(visibility_->trace(camera));
    case Mode::trust:
      return trust_frame(visibility_->trace(camera), snapshot_, camera);
    case Mode::coverage:
    case Mode::references:
      return cell_frame(visibility_->trace(camera), snapshot_, value_of_cell_, false);
    case Mode::cells:
      return cell_frame(visibility_->trace(camera), snapshot_, value_of_cell_, true);
    case Mode::error:
      return error(camera, *photograph);
    default:
      return diagnosis_frame(diagnose_tiled(*renderer_, camera, options_.blend), options_.mode);
  }
}

SoftPicture FrameRenderer::picture(const Camera& camera, const Photograph* photograph) {
  if (!colors_) return with_background(render_tiled(*renderer_, camera, options_.blend), options_.background);
  const Photograph painted = colors_->paint(frame(camera, photograph));
  return {options_.color_bar ? with_color_bar(painted, colors_->bar()) : painted, {}};
}

FloatImage FrameRenderer::numbers(const Camera& camera, const Photograph* photograph) {
  if (colors_) return float_image(frame(camera, photograph), options_.mode);
  return with_background(render_linear_tiled(*renderer_, camera, options_.blend), options_.background);
}

}  // namespace lumatlas
