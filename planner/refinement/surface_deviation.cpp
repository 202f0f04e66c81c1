// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/surface_deviation.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <limits>
#include <numeric>
#include <optional>
#include <span>

#include "mesh/base/median.h"
#include "mesh/base/requirement.h"
#include "mesh/cells/spreading.h"
#include "mesh/vertex_faces.h"
#include "planner/refinement/photometry.h"

namespace lumatlas {

namespace {

constexpr double kStepPx = 0.5;          // step of the search, in pixels of the second photograph
constexpr double kLeastIncidence = 0.3;  // least cosine between a view's direction and the surface's normal
constexpr double kAsGood = 0.1;          // a peak this much below the best correlation still counts as one
constexpr double kBestAngleDeg = 10;     // the pair of views whose angle is nearest to it is compared
constexpr std::size_t kPairs = 3;        // most pairs of views compared per point
constexpr double kMostScale = 2;         // largest ratio of pixel widths at the point between two views
constexpr double kSeenDepth = 1.01;      // a view sees a point up to this many times its stored depth
constexpr double kMostShare = 0.3;       // largest move of a patch, as a share of the depth
constexpr std::size_t kLeastPoints = 4;  // fewest compared points that measure a cell
constexpr double kLeastMeasured = 0.25;  // share of measured cells from which others take the deviation of these
constexpr double kPatchDepth = 0.02;     // most difference of a patch from what a view sees, as a share of the depth
constexpr std::uint8_t kTrusted = 128;   // least StoredView::trust of a pixel that is compared
constexpr double kMostDeviation = 1e30;  // scene units, so that sums of deviations stay finite as floats

// A view and how it sees a point.
struct PointView {
  const StoredView* view = nullptr;
  glm::dvec3 direction{0.0};  // unit, from the point to the camera
  double pixel = 0;           // width of a pixel at the point, scene units
  double depth = 0;           // scene units
};

struct SurfacePoint {
  glm::dvec3 position{0.0}, normal{0.0};
};

std::optional<SurfacePoint> middle_of(const Mesh& mesh, std::uint32_t face) {
  const glm::uvec3 corners = mesh.faces[face];
  const glm::dvec3 a(mesh.positions[corners.x]), b(mesh.positions[corners.y]), c(mesh.positions[corners.z]);
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  if (!(length > 0)) return std::nullopt;
  return SurfacePoint{(a + b + c) / 3.0, normal / length};
}

// Returns how the view sees the point; none where it does not, or within `margin_px` of its border.
std::optional<PointView> point_view(const StoredView& view, const SurfacePoint& point, double margin_px) {
  const Camera& camera = view.camera;
  const glm::dvec3 cam = camera.cam_from_world(point.position);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 image = camera.image_from_cam(cam);
  if (!(image.x >= margin_px && image.y >= margin_px && image.x < camera.width - margin_px &&
        image.y < camera.height - margin_px)) {
    return std::nullopt;
  }
  const std::size_t pixel = static_cast<std::size_t>(image.y) * camera.width + static_cast<std::size_t>(image.x);
  if (view.mask->validity[pixel] == 0 || cam.z > kSeenDepth * static_cast<double>(view.mask->depth[pixel]))
    return std::nullopt;
  if (!view.mask->trust.empty() && view.mask->trust[pixel] < kTrusted) return std::nullopt;
  const glm::dvec3 direction = glm::normalize(camera.center() - point.position);
  if (std::abs(glm::dot(direction, point.normal)) < kLeastIncidence) return std::nullopt;
  return PointView{&view, direction, cam.z / camera.fx, cam.z};
}

// Interpolates the brightness, in [0, 255], at an image position.
double brightness(const StoredPhotograph& photograph, const glm::dvec2& image) {
  const double x = std::clamp(image.x - 0.5, 0.0, photograph.width() - 1.0);
  const double y = std::clamp(image.y - 0.5, 0.0, photograph.height() - 1.0);
  const auto left = static_cast<std::size_t>(x), top = static_cast<std::size_t>(y);
  const std::size_t right = std::min<std::size_t>(left + 1, photograph.width() - 1);
  const std::size_t bottom = std::min<std::size_t>(top + 1, photograph.height() - 1);
  const auto at = [&](std::size_t column, std::size_t row) {
    const StoredPhotograph::Color rgb = photograph.color(row * photograph.width() + column);
    return 0.25 * (rgb[0] + 2 * rgb[1] + rgb[2]);
  };
  const double across = x - static_cast<double>(left), down = y - static_cast<double>(top);
  const double above = at(left, top) + across * (at(right, top) - at(left, top));
  const double below = at(left, bottom) + across * (at(right, bottom) - at(left, bottom));
  return above + down * (below - above);
}

// Two views of a point.
struct ViewPair {
  PointView first, second;
  double angle = 0;  // between them, radians
};

// Pairs `first` with the view whose angle to it is nearest to kBestAngleDeg; none where no view suits.
std::optional<ViewPair> best_pair(const std::vector<PointView>& views, const PointView& first,
                                  const DeviationOptions& options) {
  std::optional<ViewPair> best;
  double least = std::numeric_limits<double>::infinity();
  for (const PointView& second : views) {
    if (second.view == first.view || second.pixel > kMostScale * first.pixel) continue;
    if (first.pixel > kMostScale * second.pixel) continue;
    const double angle = std::acos(std::min(1.0, glm::dot(first.direction, second.direction)));
    const double degrees = glm::degrees(angle);
    if (degrees < options.least_angle_deg || degrees > options.most_angle_deg) continue;
    const double from_best = std::abs(degrees - kBestAngleDeg);
    if (from_best >= least) continue;
    least = from_best;
    best = ViewPair{first, second, angle};
  }
  return best;
}

// Returns whether the pixels that a view shows a place of the surface with see the surface and nothing before or far
// behind it.
bool sees(const PointView& seen, const glm::dvec3& place) {
  const Camera& camera = seen.view->camera;
  const glm::dvec3 cam = camera.cam_from_world(place);
  const glm::dvec2 first = glm::floor(camera.image_from_cam(cam) - 0.5);
  if (!(cam.z > 0 && first.x >= 0 && first.y >= 0 && first.x + 1 < camera.width && first.y + 1 < camera.height))
    return false;
  const std::size_t pixel = static_cast<std::size_t>(first.y) * camera.width + static_cast<std::size_t>(first.x);
  const auto is_near = [&](std::size_t at) {
    return std::abs(cam.z - static_cast<double>(seen.view->mask->depth[at])) < kPatchDepth * cam.z;
  };
  return is_near(pixel) && is_near(pixel + 1) && is_near(pixel + camera.width) && is_near(pixel + camera.width + 1);
}

// The brightness of a patch of the tangent plane around a point in the first view, less its mean.
class Patch {
 public:
  Patch(const SurfacePoint& point, const ViewPair& pair, std::uint32_t radius_px) : pair_(pair) {
    const glm::dvec3 axis = std::abs(point.normal.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 right = glm::normalize(glm::cross(point.normal, axis));
    const glm::dvec3 up = glm::cross(point.normal, right);
    const Camera &first = pair.first.view->camera, &second = pair.second.view->camera;
    const int radius = static_cast<int>(radius_px);
    for (int y = -radius; y <= radius; ++y) {
      for (int x = -radius; x <= radius; ++x) {
        const glm::dvec3 place =
            point.position + pair.second.pixel * (static_cast<double>(x) * right + static_cast<double>(y) * up);
        const glm::dvec2 image = first.image_from_cam(first.cam_from_world(place));
        shown_.push_back(brightness(*pair.first.view->photograph, image));
        in_second_.push_back(second.cam_from_world(place));
        is_whole_ = is_whole_ && sees(pair.first, place) && sees(pair.second, place);
      }
    }
    const auto count = static_cast<double>(shown_.size());
    const double mean = std::accumulate(shown_.begin(), shown_.end(), 0.0) / count;
    for (double& value : shown_) {
      value -= mean;
      squares_ += value * value;
    }
  }

  // Returns whether both views see all of it: whether it reaches over no edge of the surface.
  [[nodiscard]] bool is_whole() const { return is_whole_; }

  // Returns the standard deviation of the brightness.
  [[nodiscard]] double contrast() const { return std::sqrt(squares_ / static_cast<double>(shown_.size())); }

  // Returns the normalised correlation, in [-1, 1], of the patch with the second view's image of it after the patch has
  // moved by `moved` scene units towards the first camera.
  [[nodiscard]] double correlation(double moved) const {
    const Camera& camera = pair_.second.view->camera;
    const glm::dvec3 shift = camera.cam_from_world_rotation * (moved * pair_.first.direction);
    double sum = 0, squares = 0, products = 0;
    for (std::size_t i = 0; i < in_second_.size(); ++i) {
      const double value = brightness(*pair_.second.view->photograph, camera.image_from_cam(in_second_[i] + shift));
      sum += value;
      squares += value * value;
      products += value * shown_[i];
    }
    const double variance = squares - sum * sum / static_cast<double>(in_second_.size());
    if (!(variance > 1) || !(squares_ > 0)) return 0;
    return products / std::sqrt(variance * squares_);
  }

 private:
  ViewPair pair_;
  std::vector<glm::dvec3> in_second_;  // its points in the second camera's frame
  std::vector<double> shown_;
  double squares_ = 0;
  bool is_whole_ = true;
};

// Returns the radius of patches in photographs of that camera, pixels: in a small photograph a patch of few pixels
// already shows as much of the scene.
std::uint32_t patch_radius(const DeviationOptions& options, const Camera& camera) {
  constexpr double kWidthPerPixel = 200;
  constexpr std::uint32_t kLeast = 2;
  const auto suited = static_cast<std::uint32_t>(std::lround(camera.width / kWidthPerPixel));
  return std::min(options.patch_radius, std::max(kLeast, suited));
}

// Returns the place of the peak of a parabola through three values, in steps from the middle one, in [-0.5, 0.5].
double peak(double before, double middle, double after) {
  const double bend = before - 2 * middle + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -0.5, 0.5) : 0.0;
}

// Returns the index of the peak nearest to the middle, which is the surface, among the peaks within kAsGood of the best
// correlation: repeating texture, such as bricks, has several. Returns none where the best correlation is below
// `least_correlation` or the peak lies at the end of the search.
std::optional<std::size_t> best_place(const std::vector<double>& correlations, double least_correlation) {
  const double best = *std::max_element(correlations.begin(), correlations.end());
  if (best < least_correlation) return std::nullopt;
  const auto middle = static_cast<double>(correlations.size() - 1) / 2;
  std::optional<std::size_t> nearest;
  for (std::size_t i = 0; i < correlations.size(); ++i) {
    const double before = i > 0 ? correlations[i - 1] : -1;
    const double after = i + 1 < correlations.size() ? correlations[i + 1] : -1;
    const bool is_peak = correlations[i] >= before && correlations[i] >= after;
    if (!is_peak || correlations[i] < best - kAsGood) continue;
    const auto distance = [&](std::size_t place) { return std::abs(static_cast<double>(place) - middle); };
    if (!nearest || distance(i) < distance(*nearest)) nearest = i;
  }
  if (*nearest == 0 || *nearest + 1 == correlations.size()) return std::nullopt;
  return nearest;
}

// Returns the distance of the surface from the point that two views agree on, scene units; none without texture, or
// where the patch reaches over an edge, beyond which the views show other things beside it.
std::optional<double> distance_off(const SurfacePoint& point, const ViewPair& pair, const DeviationOptions& options) {
  const Patch patch(point, pair, patch_radius(options, pair.second.view->camera));
  if (!patch.is_whole() || patch.contrast() < options.least_contrast) return std::nullopt;
  const double step = kStepPx * pair.second.pixel / std::sin(pair.angle);
  const double most = kMostShare * std::min(pair.first.depth, pair.second.depth);
  const int steps = static_cast<int>(std::min(options.most_shift_px / kStepPx, most / step));
  if (steps < 2) return std::nullopt;
  std::vector<double> correlations;
  for (int i = -steps; i <= steps; ++i) {
    correlations.push_back(patch.correlation(i * step));
  }
  const std::optional<std::size_t> place = best_place(correlations, options.least_correlation);
  const double of_best_angle = options.most_shift_px * pair.second.pixel / std::sin(glm::radians(kBestAngleDeg));
  if (!place) return std::min(steps * step, of_best_angle);
  const double between = peak(correlations[*place - 1], correlations[*place], correlations[*place + 1]);
  return std::abs(static_cast<double>(*place) - steps + between) * step;
}

// Returns the lower median of that distance over up to kPairs pairs, from the views with the finest pixels on. A leaf
// before one view spoils only the pairs with that view.
std::optional<double> distance_off(const SurfacePoint& point, std::vector<PointView>& views,
                                   const DeviationOptions& options) {
  std::stable_sort(views.begin(), views.end(),
                   [](const PointView& a, const PointView& b) { return a.pixel < b.pixel; });
  std::vector<double> distances;
  for (std::size_t first = 0; first < std::min(kPairs, views.size()); ++first) {
    const std::optional<ViewPair> pair = best_pair(views, views[first], options);
    if (!pair) continue;
    if (const std::optional<double> off = distance_off(point, *pair, options)) distances.push_back(*off);
  }
  if (distances.empty()) return std::nullopt;
  std::sort(distances.begin(), distances.end());
  return distances[(distances.size() - 1) / 2];
}

// Returns the faces of each cell.
std::vector<std::vector<std::uint32_t>> faces_by_cell(const Surface& surface) {
  std::vector<std::vector<std::uint32_t>> faces(surface.near_cells());
  for (std::size_t face = 0; face < surface.near_faces(); ++face) {
    faces[surface.cells.cell_of_face[face]].push_back(static_cast<std::uint32_t>(face));
  }
  return faces;
}

std::vector<double> distances_off(const Snapshot& snapshot, std::size_t cell, const std::vector<std::uint32_t>& faces,
                                  const DeviationOptions& options) {
  std::vector<double> distances;
  const auto slots = snapshot.references.of_cell(cell);
  if (slots.size() < 2) return distances;
  const std::size_t points = std::min<std::size_t>(options.points, faces.size());
  for (std::size_t i = 0; i < points; ++i) {
    const std::optional<SurfacePoint> point = middle_of(snapshot.surface->mesh, faces[i * faces.size() / points]);
    if (!point) continue;
    std::vector<PointView> views;
    for (const ViewSlot slot : slots) {
      const StoredView& view = *snapshot.views[slot];
      const double margin = kMostScale * patch_radius(options, view.camera) + options.most_shift_px + 1;
      const std::optional<PointView> seen = point_view(view, *point, margin);
      if (seen) views.push_back(*seen);
    }
    if (const std::optional<double> off = distance_off(*point, views, options)) distances.push_back(*off);
  }
  return distances;
}

// Returns true if enough cells are measured to take the deviation of the others from them. Small photographs that were
// taken far apart measure few cells, which say little about the cells between.
bool enough_are_measured(const SurfaceDeviation& deviation, std::size_t near_cells) {
  const auto measured = std::count(deviation.measured.begin(), deviation.measured.end(), 1);
  return static_cast<double>(measured) >= kLeastMeasured * static_cast<double>(near_cells);
}

// Gives each cell without a measurement the mean deviation that spreads to its vertices from measured cells. Cells that
// are joined to no measured cell get the median of all.
void fill_unmeasured(const Surface& surface, SurfaceDeviation& deviation) {
  const std::span<const glm::uvec3> faces(surface.mesh.faces.data(), surface.near_faces());
  const std::vector<CellId>& cell_of_face = surface.cells.cell_of_face;
  std::vector<glm::vec4> of_vertex(surface.mesh.positions.size(), glm::vec4(0));
  for (std::size_t face = 0; face < faces.size(); ++face) {
    const CellId cell = cell_of_face[face];
    if (deviation.measured[cell] == 0) continue;
    for (int corner = 0; corner < 3; ++corner) {
      of_vertex[faces[face][corner]] += glm::vec4(deviation.of_cell[cell], 0, 0, 1);
    }
  }
  spread(faces, VertexFaces(of_vertex.size(), faces), of_vertex);
  std::vector<glm::dvec2> sums(surface.near_cells(), glm::dvec2(0));  // deviations, and their number
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      const glm::dvec4 value(of_vertex[faces[face][corner]]);
      if (value.w > 0) sums[cell_of_face[face]] += glm::dvec2(value.x / value.w, 1);
    }
  }
  std::vector<double> all;
  for (std::size_t cell = 0; cell < sums.size(); ++cell) {
    if (deviation.measured[cell] != 0) all.push_back(static_cast<double>(deviation.of_cell[cell]));
  }
  if (all.empty()) return;
  const double middle = median(all);
  for (std::size_t cell = 0; cell < sums.size(); ++cell) {
    if (deviation.measured[cell] != 0) continue;
    deviation.of_cell[cell] = static_cast<float>(sums[cell].y > 0 ? sums[cell].x / sums[cell].y : middle);
  }
}

constexpr Requirement deviation_requires{"deviation"};

}  // namespace

void check(const DeviationOptions& options) {
  deviation_requires(options.points >= 1, "points", options.points, "at least 1");
  deviation_requires(options.patch_radius >= 1 && options.patch_radius <= 32, "patch_radius", options.patch_radius,
                     "in [1, 32]");
  deviation_requires(options.most_shift_px >= 1 && options.most_shift_px <= 64, "most_shift_px", options.most_shift_px,
                     "in [1, 64]");
  deviation_requires(options.least_angle_deg > 0 && options.least_angle_deg < 90, "least_angle_deg",
                     options.least_angle_deg, "in (0, 90)");
  deviation_requires(options.most_angle_deg > options.least_angle_deg && options.most_angle_deg < 90, "most_angle_deg",
                     options.most_angle_deg, "above least_angle_deg and below 90");
  deviation_requires(options.least_correlation > 0 && options.least_correlation <= 1, "least_correlation",
                     options.least_correlation, "in (0, 1]");
  deviation_requires(options.least_contrast > 0 && std::isfinite(options.least_contrast), "least_contrast",
                     options.least_contrast, "finite and above 0");
}

SurfaceDeviation surface_deviation(const Snapshot& snapshot, const DeviationOptions& options) {
  check(options);
  check(snapshot);
  const Surface& surface = *snapshot.surface;
  const std::vector<std::vector<std::uint32_t>> faces = faces_by_cell(surface);
  std::vector<std::vector<double>> distances(faces.size());
  tbb::parallel_for(std::size_t{0}, faces.size(), [&](std::size_t cell) {
    check_cancelled(options.cancel_check);
    distances[cell] = distances_off(snapshot, cell, faces[cell], options);
  });
  SurfaceDeviation result{std::vector<float>(surface.cells.cells.size(), 0.0f),
                          std::vector<std::uint8_t>(surface.cells.cells.size(), 0)};
  for (std::size_t cell = 0; cell < faces.size(); ++cell) {
    if (distances[cell].size() < std::min<std::size_t>(kLeastPoints, faces[cell].size())) continue;
    if (distances[cell].empty()) continue;
    const double deviation = kDeviationOfMedian * median(distances[cell]);
    result.of_cell[cell] = static_cast<float>(std::min(deviation, kMostDeviation));
    result.measured[cell] = 1;
  }
  if (enough_are_measured(result, faces.size())) fill_unmeasured(surface, result);
  return result;
}

double shift_px(double deviation, double focal_length, double depth) {
  return deviation * std::sin(glm::radians(kTrustAngle)) * focal_length / depth;
}

}  // namespace lumatlas
