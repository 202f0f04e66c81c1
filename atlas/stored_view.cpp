// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/stored_view.h"

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/base/median.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require_size(const std::string& view, const char* what, std::uint32_t width, std::uint32_t height,
                  const Camera& camera) {
  if (width == camera.width && height == camera.height) return;
  throw std::invalid_argument("view " + view + ": the " + what + " is " + size_text(width, height) +
                              ", must be as large as its camera, " + size_text(camera.width, camera.height));
}

void require_count(const std::string& view, const char* field, std::size_t count, std::size_t expected) {
  if (count == expected) return;
  throw std::invalid_argument("view " + view + ": " + field + " has " + std::to_string(count) + " values, must have " +
                              std::to_string(expected) + " for its camera's image");
}

std::size_t pixels_of(const Camera& camera) {
  return std::size_t{camera.width} * camera.height;
}

}  // namespace

void require_photograph_of(const std::string& view, const Camera& camera, const Photograph& photograph) {
  require_size(view, "photograph", photograph.width, photograph.height, camera);
  require_count(view, "photograph.rgb", photograph.rgb.size(), 3 * pixels_of(camera));
  if (!photograph.valid.empty()) {
    require_count(view, "photograph.valid", photograph.valid.size(), pixels_of(camera));
  }
}

void check(const StoredView& view) {
  try {
    check(view.camera);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("view " + view.name + ": " + error.what());
  }
  require_photograph_of(view.name, view.camera, view.photograph);
  const std::size_t pixels = pixels_of(view.camera);
  require_count(view.name, "depth", view.depth.size(), pixels);
  require_count(view.name, "validity", view.validity.size(), pixels);
  if (!view.trust.empty()) require_count(view.name, "trust", view.trust.size(), pixels);
  if (!view.rim.empty()) require_count(view.name, "rim", view.rim.size(), pixels);
}

float median_depth(const StoredView& view, float below) {
  constexpr std::size_t kStride = 16;
  std::vector<float> depths;
  std::size_t finite = 0;
  for (const float depth : view.depth) {
    if (std::isfinite(depth) && depth > 0 && depth < below && finite++ % kStride == 0) depths.push_back(depth);
  }
  return depths.empty() ? 0 : upper_median(depths);
}

StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph, VisibilityBuffer visible,
                            const ValidityOptions& options, std::vector<std::uint8_t> trust) {
  require_photograph_of(name, camera, photograph);
  require_size(name, "visibility buffer", visible.width, visible.height, camera);
  require_count(name, "visibility buffer's depth", visible.depth.size(), pixels_of(camera));
  StoredView view;
  view.name = std::move(name);
  view.camera = camera;
  view.photograph = std::move(photograph);
  view.depth = std::move(visible.depth);
  view.trust = std::move(trust);
  view.validity = validity_mask(view.photograph, view.depth, view.trust, options);
  view.rim = rim_pixels(view.photograph, view.depth, options);
  return view;
}

}  // namespace lumatlas
