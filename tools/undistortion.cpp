// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/undistortion.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace lumatlas {
namespace {

// The largest distance from the axis, in the plane z = 1, that a pixel of the view looks at.
double largest_radius(const Camera& view) {
  const double x = std::max(std::abs(view.cx), std::abs(view.width - view.cx)) / view.fx;
  const double y = std::max(std::abs(view.cy), std::abs(view.height - view.cy)) / view.fy;
  return std::hypot(x, y);
}

// Where a pixel of a view finds its colour in the lens's photograph.
class SourceOfPixel {
 public:
  SourceOfPixel(const CameraModel& lens, const Camera& view)
      : SourceOfPixel(lens, view, reach(lens, largest_radius(view))) {}
  SourceOfPixel(const CameraModel& lens, const Camera& view, double lens_reach)
      : lens_(lens), view_(view), squared_reach_(lens_reach * lens_reach) {}

  // `margin`: how far inside the photograph's edges the place must be, pixels.
  [[nodiscard]] std::optional<glm::dvec2> operator()(const glm::dvec2& pixel, double margin = 0) const {
    const double x = (pixel.x - view_.cx) / view_.fx;
    const double y = (pixel.y - view_.cy) / view_.fy;
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

// The least zoom in [1, kLargestZoom] that leaves no border, or kLargestZoom if all of them leave one.
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
  if (borderless(1)) {
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
  for (int i = 0; i < kGrid * kGrid; ++i) {
    const glm::dvec2 cell(i % kGrid + 0.5, i / kGrid + 0.5);
    if (source(glm::dvec2(view.width, view.height) * cell / static_cast<double>(kGrid))) {
      return true;
    }
  }
  return false;
}

// The four pixels round a place of the photograph, clamped at its edges, and their weights in 1/256.
struct Footprint {
  std::size_t corners[4];
  std::uint32_t weights[4];
};

Footprint footprint(const Photograph& photograph, const glm::dvec2& place) {
  const double x = std::clamp(place.x - 0.5, 0.0, photograph.width - 1.0);
  const double y = std::clamp(place.y - 0.5, 0.0, photograph.height - 1.0);
  const auto x0 = static_cast<std::size_t>(x);
  const auto y0 = static_cast<std::size_t>(y);
  const std::size_t right = x0 + 1 < photograph.width ? 1 : 0;
  const std::size_t below = y0 + 1 < photograph.height ? photograph.width : 0;
  const std::size_t corner = y0 * photograph.width + x0;
  const auto u = static_cast<std::uint32_t>((x - static_cast<double>(x0)) * 256 + 0.5);
  const auto v = static_cast<std::uint32_t>((y - static_cast<double>(y0)) * 256 + 0.5);
  return {{corner, corner + right, corner + below, corner + below + right},
          {(256 - u) * (256 - v), u * (256 - v), (256 - u) * v, u * v}};
}

// False if the photograph itself is masked there.
bool resample(const Photograph& photograph, const glm::dvec2& place, std::uint8_t* rgb) {
  const Footprint f = footprint(photograph, place);
  if (!photograph.valid.empty()) {
    for (int i = 0; i < 4; ++i) {
      if (f.weights[i] > 0 && photograph.valid[f.corners[i]] == 0) {
        return false;
      }
    }
  }
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::uint32_t sum = 1u << 15;  // rounds
    for (int i = 0; i < 4; ++i) {
      sum += f.weights[i] * photograph.rgb[3 * f.corners[i] + channel];
    }
    rgb[channel] = static_cast<std::uint8_t>(sum >> 16);
  }
  return true;
}

// True if every pixel of the row is valid.
bool undistort_row(const Photograph& photograph, const SourceOfPixel& source, std::uint32_t row, Photograph& out) {
  bool complete = true;
  for (std::uint32_t column = 0; column < out.width; ++column) {
    const std::size_t pixel = std::size_t{row} * out.width + column;
    const std::optional<glm::dvec2> place = source({column + 0.5, row + 0.5});
    const bool seen = place && resample(photograph, *place, &out.rgb[3 * pixel]);
    out.valid[pixel] = seen ? 255 : 0;
    complete = complete && seen;
  }
  return complete;
}

void require_size(const char* what, std::uint32_t width, std::uint32_t height, const CameraModel& lens) {
  if (width != lens.width || height != lens.height) {
    throw std::invalid_argument("undistort: the " + std::string(what) + " is " + std::to_string(width) + "x" +
                                std::to_string(height) + ", must be the lens's " + std::to_string(lens.width) + "x" +
                                std::to_string(lens.height));
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

Photograph undistort(Photograph photograph, const CameraModel& lens, const Camera& view) {
  require_size("photograph", photograph.width, photograph.height, lens);
  require_size("view", view.width, view.height, lens);
  if (!is_distorted(lens)) {
    return photograph;
  }
  const std::size_t pixels = std::size_t{view.width} * view.height;
  Photograph out{view.width, view.height, std::vector<std::uint8_t>(3 * pixels), std::vector<std::uint8_t>(pixels)};
  const SourceOfPixel source(lens, view);
  std::vector<std::uint8_t> complete(view.height);
  tbb::parallel_for(std::uint32_t{0}, view.height,
                    [&](std::uint32_t row) { complete[row] = undistort_row(photograph, source, row, out) ? 1 : 0; });
  if (std::all_of(complete.begin(), complete.end(), [](std::uint8_t c) { return c != 0; })) {
    out.valid.clear();
  }
  return out;
}

}  // namespace lumatlas
