// SPDX-License-Identifier: GPL-3.0-or-later
// Scores how well a rendering reproduces the held-out photograph: over the whole frame, and over the pixels that see
// the mesh.
//
// Conventions of every function here:
//   The two pictures have the same size, at least one pixel; otherwise std::invalid_argument.
//   `mask` has one entry per pixel, row by row; a pixel counts where it is not 0. An empty mask counts all pixels.
//   Pixels outside the lens's image (photograph.valid is 0) never count; rendering.valid is not looked at: a pixel
//   that the method left empty counts with whatever colour it shows.
//   No score depends on what either picture holds at pixels that do not count, which are black where a lens was
//   undistorted or a mask applies.
//   Where no pixel counts, a score is NaN and a gain is 1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "atlas/images/photograph.h"

namespace lumatlas {

struct Scores {
  double psnr = 0;  // dB; infinity for identical pictures
  double ssim = 0;  // in [-1, 1]; 1 for identical pictures
};

// Peak signal-to-noise ratio of the 8-bit sRGB values, all three channels together.
[[nodiscard]] double psnr(const Photograph& rendering, const Photograph& photograph,
                          std::span<const std::uint8_t> mask);

// Structural similarity, Wang et al. 2004: of luma (Rec. 601, not rounded), Gaussian window of 11x11 with sigma 1.5, K1
// = .01, K2 = .03, L = 255, population covariance. Pictures are continued beyond their borders by reflection, edge
// pixel repeated, so every pixel has a value. The score is the mean over the pixels that count, including those near
// the border, so that both scores cover the same pixels. scikit-image's own mean leaves out a border of 5 pixels; its
// full map is the same. A window that reaches beyond the pixels that count spreads its weight over those that do: see
// ssim.cpp.
[[nodiscard]] double ssim(const Photograph& rendering, const Photograph& photograph,
                          std::span<const std::uint8_t> mask);

// Exposure gains are looked for within [1 / kLargestGain, kLargestGain].
inline constexpr double kLargestGain = 64;

// The exposure gain on the rendering, in linear light, that minimises the mean square error of apply_gain(rendering,
// gain): the global minimum, so that a fitted PSNR is never below the raw one. The middle of the range of gains that
// give the minimum; 1 if that range holds 1.
[[nodiscard]] double fit_gain(const Photograph& rendering, const Photograph& photograph,
                              std::span<const std::uint8_t> mask);

// Every value times `gain` in linear light, back to 8-bit sRGB; a gain of 1 changes nothing.
// Throws std::invalid_argument unless gain is finite and not negative.
[[nodiscard]] Photograph apply_gain(const Photograph& image, double gain);

// Scores over one set of pixels of a held-out view.
struct RegionScores {
  std::size_t pixels = 0;          // that counted
  Scores raw;                      // the rendering as it is
  Scores fitted;                   // after `gain`
  std::optional<Scores> aligned;   // fitted, with the camera's pose refined as well; absent where it was not measured
  std::size_t aligned_pixels = 0;  // that `aligned` is over
  double gain = 1;                 // fit_gain
  double textured = 0;             // share of `pixels` that a stored photograph coloured, in [0, 1]; NaN of no pixels
};

// One held-out view.
struct ViewScores {
  RegionScores frame;  // every pixel inside the lens's image and its mask, whether the mesh is seen there or not
  RegionScores mesh;   // those where the mesh is seen; `aligned` over those that all methods have in common
};

// All but the aligned scores. `textured` has one entry per pixel, not 0 where a stored photograph coloured it; empty:
// none.
[[nodiscard]] RegionScores score_region(const Photograph& rendering, const Photograph& photograph,
                                        std::span<const std::uint8_t> mask, std::span<const std::uint8_t> textured);

// Stands for infinity where a number must be finite, in means and in JSON. Above every PSNR of pictures that differ:
// one level in one channel of 65536 x 65536 pixels is 149.2 dB.
inline constexpr double kPsnrOfIdentical = 150;

// Means over the views that have pixels; NaN if none has. An infinite PSNR enters a mean as kPsnrOfIdentical, unless
// all are infinite.
struct MeanScores {
  std::size_t views = 0;  // that have pixels
  Scores raw;
  Scores fitted;
  std::optional<Scores> aligned;  // over the views with aligned_pixels, if every view with pixels was aligned
  double textured = 0;            // share of the pixels that count in all views
};
[[nodiscard]] MeanScores mean_scores(std::span<const RegionScores> views);

// The means of one method over all scored views.
struct MethodScores {
  MeanScores frame;
  MeanScores mesh;
};
[[nodiscard]] MethodScores method_scores(std::span<const ViewScores> views);

}  // namespace lumatlas
