// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/lenses/undistortion.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/base/number_text.h"
#include "tools/scene/lenses/resampling.h"

namespace lumatlas {
namespace {

// The largest distance from the axis, in the plane z = 1, that a pixel of the view looks at.
double largest_radius(const Camera& view) {
  const double x = std::max(std::abs(view.cx), std::abs(view.width - view.cx)) / view.fx;
  const double y = std::max(std::abs(view.cy), std::abs(view.height - view.cy)) / view.fy;
  return std::hypot(x, y);
}

double squared(double value) {
  return value * value;
}

// The position in the lens's photograph from which a pixel of a view takes its colour.
class SourceOfPixel {
 public:
  SourceOfPixel(const CameraModel& lens, const Camera& view, const LensCorrection& correction = {},
                const ShutterMotion& motion = {})
      : lens_(lens),
        view_(view),
        correction_(correction),
        motion_(motion),
        squared_reach_(squared(reach(lens, largest_radius(view)))) {}
  SourceOfPixel(const CameraModel& lens, const Camera& view, double lens_reach)
      : lens_(lens), view_(view), squared_reach_(squared(lens_reach)) {}

  // `margin`: how far inside the photograph's edges the place must be, pixels.
  [[nodiscard]] std::optional<glm::dvec2> operator()(const glm::dvec2& pixel, double margin = 0) const {
    const glm::dvec2 given = uncorrected(correction_, view_, when_read(motion_, view_, pixel));
    const double x = (given.x - view_.cx) / view_.fx;
    const double y = (given.y - view_.cy) / view_.fy;
    if (!(x * x + y * y <= squared_reach_)) {
      return std::nullopt;
    }
    const std::optional<glm::dvec2> place = image_from_cam(lens_, {x, y, 1.0});
    const bool inside = place && place->x >= margin && place->y >= margin && place->x <= lens_.width - margin &&
                        place->y <= lens_.height - margin;
    return inside ? place : std::nullopt;
  }

 private:
  const CameraModel& lens_;
  const Camera& view_;
  LensCorrection correction_;
  ShutterMotion motion_;
  double squared_reach_;
};

// Centres of pixels along the four edges, corners included.
std::vector<glm::dvec2> pixels_along_the_edges(const Camera& view) {
  constexpr int kPerEdge = 64;
  std::vector<glm::dvec2> pixels;
  for (int i = 0; i <= kPerEdge; ++i) {
    const double x = 0.5 + (view.width - 1.0) * i / kPerEdge;
    const double y = 0.5 + (view.height - 1.0) * i / kPerEdge;
    pixels.insert(pixels.end(), {{x, 0.5}, {x, view.height - 0.5}, {0.5, y}, {view.width - 0.5, y}});
  }
  return pixels;
}

Camera magnified(const Camera& view, double zoom) {
  Camera result = view;
  result.fx *= zoom;
  result.fy *= zoom;
  return result;
}

// The least zoom in [1, kLargestZoom] that leaves no border, or 1 if none of them does.
double least_zoom(const CameraModel& lens, const Camera& view, double lens_reach) {
  // Between the sampled pixels of an edge the border may come nearer; a quarter of the half pixel that the outermost
  // pixel centres have to spare makes up for it.
  constexpr double kMargin = 0.125;
  constexpr int kHalvings = 20;
  const std::vector<glm::dvec2> edges = pixels_along_the_edges(view);
  const auto borderless = [&](double zoom) {
    const Camera camera = magnified(view, zoom);
    const SourceOfPixel source(lens, camera, lens_reach);
    return std::all_of(edges.begin(), edges.end(), [&](const glm::dvec2& p) { return source(p, kMargin).has_value(); });
  };
  if (borderless(1) || !borderless(kLargestZoom)) {
    return 1;
  }
  double low = 1;
  double high = kLargestZoom;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = (low + high) / 2;
    (borderless(middle) ? high : low) = middle;
  }
  return high;
}

// Looked at on a coarse grid.
bool sees_anything(const CameraModel& lens, const Camera& view, double lens_reach) {
  constexpr int kGrid = 32;
  const SourceOfPixel source(lens, view, lens_reach);
  for (int row = 0; row < kGrid; ++row) {
    for (int column = 0; column < kGrid; ++column) {
      if (source({view.width * (column + 0.5) / kGrid, view.height * (row + 0.5) / kGrid})) {
        return true;
      }
    }
  }
  return false;
}

using Place = std::optional<glm::dvec2>;

// Writes the source of each pixel of a row. Between every eighth pixel, where the lens
// is asked, places are interpolated: even in a fisheye of 300 pixels focal length they stay within 0.02 pixels.
void find_sources(const SourceOfPixel& source, std::uint32_t row, std::vector<Place>& places) {
  constexpr std::size_t kStep = 8;
  const auto exact = [&](std::size_t column) { return source({static_cast<double>(column) + 0.5, row + 0.5}); };
  std::size_t begin = 0;
  places[0] = exact(0);
  for (; begin + kStep < places.size(); begin += kStep) {
    const Place first = places[begin];
    const Place last = exact(begin + kStep);
    for (std::size_t i = 1; i < kStep; ++i) {
      const double t = static_cast<double>(i) / kStep;
      places[begin + i] = first && last ? Place((1 - t) * *first + t * *last) : exact(begin + i);
    }
    places[begin + kStep] = last;
  }
  for (std::size_t column = begin + 1; column < places.size(); ++column) {
    places[column] = exact(column);
  }
}

// True if every pixel of the row is valid.
bool undistort_row(const Photograph& photograph, const SourceOfPixel& source, std::uint32_t row,
                   std::vector<Place>& places, Photograph& out) {
  find_sources(source, row, places);
  bool complete = true;
  std::size_t pixel = std::size_t{row} * out.width;
  for (const Place& place : places) {
    const bool seen = place && resample(photograph, *place, AtEdges::clamp, &out.rgb[3 * pixel]);
    out.valid[pixel] = seen ? 255 : 0;
    complete = complete && seen;
    ++pixel;
  }
  return complete;
}

void require_size(const char* what, std::uint32_t width, std::uint32_t height, const CameraModel& lens) {
  if (width != lens.width || height != lens.height) {
    throw std::invalid_argument("undistort: the " + std::string(what) + " is " + size_text(width, height) +
                                ", must be the lens's " + size_text(lens.width, lens.height));
  }
}

}  // namespace

Camera pinhole_view(const CameraModel& lens) {
  check(lens);
  if (!can_be_pinhole(lens.model)) {
    throw std::invalid_argument("lens model " + std::string(name(lens.model)) +
                                " is a full panorama, which no pinhole view can hold: render views of it first");
  }
  Camera view;
  view.width = lens.width;
  view.height = lens.height;
  view.fx = lens.focal_length().x;
  view.fy = lens.focal_length().y;
  view.cx = lens.principal_point().x;
  view.cy = lens.principal_point().y;
  if (!is_distorted(lens)) {
    return view;
  }
  const double lens_reach = reach(lens, largest_radius(view));
  const Camera zoomed = magnified(view, least_zoom(lens, view, lens_reach));
  if (!sees_anything(lens, zoomed, lens_reach)) {
    throw std::invalid_argument("its distortion (" + std::string(parameter_names(lens.model)) +
                                ") folds the picture over, so that no pinhole view of it is left: calibrate it anew");
  }
  return zoomed;
}

Photograph undistort(Photograph photograph, const CameraModel& lens, const Camera& view,
                     const LensCorrection& correction, const ShutterMotion& motion) {
  check(correction);
  check(motion);
  require_size("photograph", photograph.width, photograph.height, lens);
  require_size("view", view.width, view.height, lens);
  if (!is_distorted(lens) && correction == LensCorrection{} && motion == ShutterMotion{}) {
    return photograph;
  }
  const std::size_t pixels = std::size_t{view.width} * view.height;
  Photograph out{view.width, view.height, std::vector<std::uint8_t>(3 * pixels), std::vector<std::uint8_t>(pixels)};
  const SourceOfPixel source(lens, view, correction, motion);
  std::vector<std::uint8_t> complete(view.height);
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, view.height, 8), [&](const auto& rows) {
    std::vector<Place> places(view.width);
    for (std::uint32_t row = rows.begin(); row < rows.end(); ++row) {
      complete[row] = undistort_row(photograph, source, row, places, out) ? 1 : 0;
    }
  });
  if (std::all_of(complete.begin(), complete.end(), [](std::uint8_t c) { return c != 0; })) {
    out.valid.clear();
  }
  return out;
}

}  // namespace lumatlas
