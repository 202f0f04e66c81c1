// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs with measured depths, as evidence for or against the faces of a mesh.
#pragma once

#include <boost/pending/disjoint_sets.hpp>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"
#include "tools/stereo/agreeing_depths.h"

namespace lumatlas {

// A photograph with depths, all of one size.
struct MeasuredView {
  StereoDepth measured;
  std::vector<glm::vec3> color;     // one per pixel, sRGB in [0, 255]
  std::vector<std::uint8_t> valid;  // one per pixel: 0 if it does not count, else 1

  // Returns whether two photographs or more confirm the depth of a pixel that counts.
  [[nodiscard]] bool is_confirmed(std::size_t pixel) const;

  // Returns the largest difference from the measured depth of a pixel that counts as the same, scene units.
  [[nodiscard]] float same_depth(std::size_t pixel) const;

  // Returns a point on the ray through a pixel's middle at a depth.
  [[nodiscard]] glm::dvec3 point_at(std::size_t pixel, float depth) const;

  // Returns where a point is in the image; none: behind the camera, or less than a pixel from the border or outside.
  [[nodiscard]] std::optional<glm::dvec2> image_of(const glm::dvec3& point) const;

  // Returns where the view measures a point; none: it measures another depth there, or the pixel does not count.
  [[nodiscard]] std::optional<glm::dvec2> where_measured(const glm::dvec3& point) const;

  // Returns where the view sees a point of a mesh; none: something else is before it, or the pixel does not count.
  // `visible`: of the mesh, from the view's camera.
  [[nodiscard]] std::optional<glm::dvec2> where_seen(const glm::dvec3& point, const VisibilityBuffer& visible) const;

  // Returns the bilinear colour at an image position that is at least a pixel from the border.
  [[nodiscard]] glm::vec3 color_at(const glm::dvec2& at) const;
};

// A pixel of a view that is evidence about a face.
struct FacePixel {
  std::uint32_t view, pixel, face;
};

// Connected groups of some faces of a mesh, by a vertex that represents each.
class FaceGroups {
 public:
  FaceGroups(const Mesh& mesh, const std::vector<bool>& wanted);
  [[nodiscard]] std::uint32_t of(std::size_t face);

 private:
  const Mesh& mesh_;
  boost::disjoint_sets_with_storage<> sets_;
};

// A group of faces, by the pixels that are evidence about it.
struct PixelGroup {
  glm::dvec3 sum{0};  // of a vertex of each pixel's face
  std::vector<FacePixel> pixels;

  void add(const FacePixel& pixel, const Mesh& mesh);
};

// Returns whether three views from directions 4 degrees apart have eight of the group's pixels or more.
[[nodiscard]] bool is_seen_around(const PixelGroup& group, std::span<const MeasuredView> views);

// The squared errors of the colour of pixels in other views, if they show one or the other of two points.
struct ColorErrors {
  double nearer = 0, farther = 0;
  std::size_t compared = 0;  // number of pixels and views

  ColorErrors& operator+=(const ColorErrors& other);
};

// Adds a pixel's errors in a view that sees both points, if they are two pixels apart there.
void compare_colors(const MeasuredView& view, const std::optional<glm::dvec2>& nearer,
                    const std::optional<glm::dvec2>& farther, const glm::vec3& color, ColorErrors& errors);

}  // namespace lumatlas
