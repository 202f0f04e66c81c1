// SPDX-License-Identifier: GPL-3.0-or-later
// Options of the renderer, which blends the best K valid views of a cell to one pixel. Erat et al. 2019, section 3.1;
// Buehler et al. 2001 for the fade.
//
//   w_dir = max(0, cos of the angle at X between novel and stored camera)
//   w_pos = min(o, i) / max(o, i)                   o, i: distance of the novel and of the stored camera from X
//           (printed: max(0, 1 - o / i), which is 0 at equal distance and prefers far views)
//   w     = faded(lambda w_dir + (1 - lambda) w_pos, left)
//   share ~ (w - w_next) / max(1 - w + min(kEven, kEvenSlope (1 - w_best)), kLeastPenalty)
//           w_next: the (K+1)th largest w; w_best: the largest      (printed: w)
//
// faded() is faded_weight() of blend/geometric_weight.h. `left` is the share of the view that is left at X. It is 0
// where X is behind the stored depth or its pixel is invalid. Elsewhere it is the mask of atlas/views/validity.h, which
// is interpolated except at rims, times rim_share() at a rim, which is 0 without `rims`, and times frame_share() in a
// band along the photograph's border (printed: no band, and a mask of 0 and 1).
#pragma once

#include <cstdint>

namespace lumatlas {

// Above this many blended views the shader's registers spill; shared with the shader.
inline constexpr std::uint32_t kMaxBlendedViews = 8;

// Most pixels of a photograph, along a side, that a pixel of the picture covers before a coarser level is sampled;
// shared with the shader. Above 1, so that a picture from near a photograph's camera is as sharp as the photograph.
inline constexpr double kSharpFootprint = 1.4;

inline constexpr std::uint32_t kMostSupersampling = 4;

// Least 1 - w by which a view's share is divided; smaller differences are rounding in the shader's floats. Shared with
// the shader. A view of w = 0.999 then has a thousandth of the share of one whose 1 - w is this.
inline constexpr double kLeastPenalty = 1e-6;

// What evens out the shares of photographs from nearly the same direction, which show the surface equally well: their
// mean has less grain than one of them. kEven is 1 - w at 6 degrees. It falls to 0 with 1 - w of the best view, by this
// slope, from 3 degrees on: a picture from a photograph's own camera is that photograph. Shared with the shader.
inline constexpr double kEven = 0.004;
inline constexpr double kEvenSlope = 4;

// The surface bends by more than this many pixel widths at a silhouette, see supersampling.h. Shared with the shader.
inline constexpr double kSilhouetteBend = 4;
// Samples of a pixel at a silhouette are of one surface up to this, see supersampling.h. Shared with the shader.
inline constexpr double kSameSurface = 2;

// The angles between novel and stored camera, seen from a point at a rim, at which the stored one's weight begins to
// fall, and is 0; shared with the shader as cosines.
inline constexpr double kRimNearDegrees = 10;
inline constexpr double kRimFarDegrees = 30;

struct BlendOptions {
  enum class Position {
    ratio,    // min / max of the two distances
    printed,  // the paper's
  };
  enum class Exposure {
    nearby,  // the exposure of photographs taken nearby, see exposure.h
    model,   // the common exposure of all stored views
  };
  enum class Sampling {
    linear,  // between the 2 x 2 pixels of a photograph next to a point
    cubic,   // cubic over 4 x 4 texels on all but their coarsest level: see cubic_kernel.h
  };
  enum class Antialias {
    silhouettes,  // pixels at the rims of surfaces, see supersampling.h
    all,          // every pixel
  };
  std::uint32_t views = 3;  // K, [1, 8]
  double lambda = 0.8;      // weight of direction against position, [0, 1]
  Position position = Position::ratio;
  // The nearer sides of depth edges, which models with masks of both sides do not have, are shown from about where they
  // were photographed; printed: not at all
  bool rims = true;
  bool fade_last = true;  // subtract the (K+1)th weight, so that views enter and leave at 0; printed: no
  // Divide what a view counts by 1 - w, so that a picture from where a photograph was taken is that photograph wherever
  // it is valid, and becomes it continuously (the epipole consistency of Buehler et al.); printed: no
  bool consistent = true;
  // Width of the band along a photograph's border in which its view fades out, as a share of the photograph's shorter
  // side, [0, 0.5]. Shares of all views are then continuous where one ends, also where it is only the next best one.
  // At masks and depth edges ValidityOptions::fade_px does the same. printed: 0, views end in a line
  double frame_fade = 0.005;
  // The interpolation of colours; validity is always sampled linearly. With a gutter of 1 pixel
  // around tiles colours are sampled linearly too.
  Sampling sampling = Sampling::cubic;  // printed, as GL samples: linear
  // Blurs colours by the surface's deviation (Snapshot::cell_deviation), see footprint.h; printed: no
  bool soften = true;
  // Blurs the picture across depth edges by the deviation of the nearer surface, see soft_edges.h; printed: no
  bool soft_edges = true;
  // Continues surfaces past their outlines by their deviation, see outlines.h; printed: no
  bool outlines = true;
  bool prefilter = true;                 // views nearer than the picture's camera are sampled at their coarser levels
  Exposure exposure = Exposure::nearby;  // the picture's; printed: model, for sections 3.1 and 3.3 name no other
  // Width over which neighbouring cells fade into each other, as a share of the cell size, [0, 1]; printed: 0
  double border_width = 0.1;
  // N: colours are means over N x N samples a pixel, see supersampling.h, [1, 4]. Doing so for all pixels takes N * N +
  // 1 times as long, unless N is 1.
  std::uint32_t supersample = 2;                 // printed, which names no samples: 1
  Antialias antialias = Antialias::silhouettes;  // which pixels; with N = 1 there is no difference
  double occlusion_tolerance = 0.02;  // X may lie this share of its depth behind the stored depth, >= 0; printed: 0

  [[nodiscard]] static BlendOptions printed();
  // Returns options that take a third to a half of the time: linear sampling, one sample a pixel, cells that do not
  // fade into each other.
  [[nodiscard]] static BlendOptions draft();
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const BlendOptions& options);

}  // namespace lumatlas
