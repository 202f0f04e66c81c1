// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/surface_trust.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Orthogonal_k_neighbor_search.h>
#include <CGAL/Search_traits_3.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <vector>

#include "mesh/visibility/visibility.h"

namespace lumatlas {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using TriangleTree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using Search = CGAL::Orthogonal_k_neighbor_search<CGAL::Search_traits_3<Kernel>>;

constexpr std::uint32_t kGlancePx = 160;    // longer side of the pictures that are looked at
constexpr std::size_t kMostPoints = 50000;  // whose distance is measured
constexpr std::size_t kPixelStep = 7;       // step between covered pixels whose distance from the points is measured

Point cgal(const glm::dvec3& p) {
  return {p.x, p.y, p.z};
}

double pixels_per_length(const glm::dvec3& at, const Camera& view) {
  return std::max(view.fx, view.fy) / glm::distance(view.center(), at);
}

double most_pixels_per_length(const glm::dvec3& at, const std::vector<std::uint32_t>& seen_by,
                              std::span<const Camera> views) {
  double most = 0;
  for (const std::uint32_t view : seen_by) most = std::max(most, pixels_per_length(at, views[view]));
  return most;
}

Triangles triangles_of(const Mesh& mesh) {
  Triangles triangles;
  triangles.reserve(mesh.faces.size());
  for (const glm::uvec3& face : mesh.faces) {
    triangles.emplace_back(cgal(mesh.positions[face[0]]), cgal(mesh.positions[face[1]]), cgal(mesh.positions[face[2]]));
  }
  return triangles;
}

void measure_points(const Mesh& mesh, const ScenePoints& points, std::span<const Camera> views, SurfaceTrust& trust) {
  const Triangles triangles = triangles_of(mesh);
  const TriangleTree tree(triangles.begin(), triangles.end());
  std::vector<double> distances;
  const std::size_t step = points.positions.size() / kMostPoints + 1;
  for (std::size_t i = 0; i < points.positions.size(); i += step) {
    const double scale = most_pixels_per_length(points.positions[i], points.views[i], views);
    if (!(scale > 0 && std::isfinite(scale))) continue;
    distances.push_back(scale * std::sqrt(tree.squared_distance(cgal(points.positions[i]))));
  }
  if (distances.empty()) return;
  const auto near = std::count_if(distances.begin(), distances.end(), [](double d) { return d <= kOnSurfacePx; });
  trust.points_on_surface = static_cast<double>(near) / static_cast<double>(distances.size());
}

class PixelCounter {
 public:
  PixelCounter(const Mesh& mesh, const ScenePoints& points) : visibility_(make_ray_visibility(mesh)) {
    std::vector<Point> all;
    all.reserve(points.positions.size());
    for (const glm::dvec3& position : points.positions) all.push_back(cgal(position));
    tree_.insert(all.begin(), all.end());
  }

  // Adds a view. Views come in ascending order of `index`.
  void look(const Camera& full_size, std::size_t index) {
    const Camera view = full_size.shrunk_to(kGlancePx);
    visibility_->trace(view, buffer_);
    count_frame(index);
    for (std::size_t pixel = 0; pixel < buffer_.face.size(); ++pixel) {
      ++pixels_;
      if (buffer_.face[pixel] == FaceId::none) continue;
      if (covered_++ % kPixelStep != 0) continue;
      const std::size_t row = pixel / view.width, column = pixel % view.width;
      const glm::dvec2 center(static_cast<double>(column) + 0.5, static_cast<double>(row) + 0.5);
      const glm::dvec3 at = view.center() + double{buffer_.depth[pixel]} * view.ray(center);
      if (tree_.empty()) continue;  // there is no distance from points
      const Search nearest(tree_, cgal(at), 1);
      const double distance_px = std::sqrt(nearest.begin()->second) * pixels_per_length(at, full_size);
      ++measured_;
      if (distance_px > kFarFromPointsPx) ++guessed_;
    }
  }

  void put_into(SurfaceTrust& trust) const {
    trust.frames_mostly_empty = frames_ > 0 ? static_cast<double>(mostly_empty_) / static_cast<double>(frames_) : 0;
    trust.emptiest_covered = frames_ > 0 ? emptiest_covered_ : 0;
    trust.emptiest_view = emptiest_view_;
    trust.pixels_covered = pixels_ > 0 ? static_cast<double>(covered_) / static_cast<double>(pixels_) : 0;
    trust.pixels_guessed = measured_ > 0 ? static_cast<double>(guessed_) / static_cast<double>(measured_) : 0;
  }

 private:
  void count_frame(std::size_t index) {
    constexpr double kMostlyEmpty = 0.5;
    const auto empty = std::count(buffer_.face.begin(), buffer_.face.end(), FaceId::none);
    const double covered = 1 - static_cast<double>(empty) / static_cast<double>(buffer_.face.size());
    ++frames_;
    if (covered < kMostlyEmpty) ++mostly_empty_;
    if (covered >= emptiest_covered_) return;
    emptiest_covered_ = covered;
    emptiest_view_ = index;
  }

  std::unique_ptr<Visibility> visibility_;
  Search::Tree tree_;
  VisibilityBuffer buffer_;
  std::size_t pixels_ = 0, covered_ = 0, measured_ = 0, guessed_ = 0, frames_ = 0, mostly_empty_ = 0,
              emptiest_view_ = 0;
  double emptiest_covered_ = 2;  // more than any frame
};

}  // namespace

SurfaceTrust surface_trust(const Mesh& mesh, const ScenePoints& points, std::span<const Camera> views,
                           const std::function<void()>& progress) {
  SurfaceTrust trust;
  PixelCounter pixels(mesh, points);
  measure_points(mesh, points, views, trust);
  const std::size_t step = (views.size() + kMostTrustViews - 1) / kMostTrustViews;
  for (std::size_t view = 0; step > 0 && view < views.size(); view += step) {
    pixels.look(views[view], view);
    progress();
  }
  pixels.put_into(trust);
  return trust;
}

}  // namespace lumatlas
