// SPDX-License-Identifier: GPL-3.0-or-later
// Blurs the picture across depth edges, as wide as the nearer surface is off.
//
// An outline that the mesh has beside its true place is a hard step in the picture at the wrong place. A step as soft
// as the place is uncertain is nearer to the photograph wherever the true one is. Let D be the deviation of a surface
// (Snapshot::cell_deviation, scene units), at most kMostOfMedian times the median of all cells, f the picture's focal
// length fx in pixels, z the depth, and S the shift that `render --mode trust` shows, that of a photograph
// kSoftEdgeDegrees aside:
//
//   S = D sin(kSoftEdgeDegrees) f / z                      pixels
//   v = min(max(0, S^2 - 1), kMostEdgeBlur^2)              variance of the blur of the edges of that surface, pixels^2
//
// Up to a shift of one pixel nothing is blurred, as in footprint.h. The limit by the median keeps exact scenes sharp,
// where gloss and glass alone raise the deviation of a few cells.
//
// A pixel with depth z is at an edge if two neighbours opposite each other in its row or its column, with z' and z'',
// see a surface too and
//
//   |z / z' + z / z'' - 2| > kEdgeBend.
//
// A plane has 0 on the left side, from all directions. The edge has the v of the nearest of the three. Other pixels
// take part by the largest
//
//   V = v - kBlurFall r^2       r: distance in pixels from an edge of variance v, at most kEdgeReach in row and column
//
// and each pixel with V above 0 becomes the mean of the pixels that see a surface, at most kEdgeReach away in row and
// column, by the weight exp(-d^2 / (2 V)) at distance d, in linear light. All other pixels stay the same, to the last
// bit. So the blur ends 2.5 standard deviations from the edge, continuously.
#pragma once

#include <cstdint>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

// All shared with the shaders.
inline constexpr double kSoftEdgeDegrees = 10;
inline constexpr double kMostOfMedian = 2;
inline constexpr double kMostEdgeBlur = 2;  // standard deviation, pixels
inline constexpr double kEdgeBend = 0.03;
inline constexpr double kBlurFall = 0.16;
inline constexpr int kEdgeReach = 5;  // pixels: sqrt(kMostEdgeBlur^2 / kBlurFall)

// Returns the variance v of the edges of a surface, pixels^2. `most_deviation`: kMostOfMedian times the median.
[[nodiscard]] double edge_variance(double deviation, double most_deviation, double focal_length, double depth);

// Returns V for each pixel, 0 or more. `deviation`: of the surface at each pixel, scene units. Throws
// std::invalid_argument unless `visible` has a depth and a face, and `deviation` a value, for each pixel of the
// camera's image.
[[nodiscard]] std::vector<float> edge_blur(const Camera& camera, const VisibilityBuffer& visible,
                                           const std::vector<float>& deviation, double most_deviation);

// Returns an sRGB picture blurred by V of each pixel. `seen`: 1 for each pixel that sees a surface, else 0. Pixels that
// see none neither change nor count. Throws std::invalid_argument unless both have a value for each pixel.
[[nodiscard]] Photograph with_soft_edges(const Photograph& picture, const std::vector<std::uint8_t>& seen,
                                         const std::vector<float>& blur);

}  // namespace lumatlas
