// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/views/stored_view.h"

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

void require_photograph_of(const std::string& view, const Camera& camera, const StoredPhotograph& photograph) {
  require_size(view, "photograph", photograph.width(), photograph.height(), camera);
}

void require_mask_of(const std::string& view, const Camera& camera, const ViewMask& mask) {
  const std::size_t pixels = pixels_of(camera);
  require_count(view, "depth", mask.depth.size(), pixels);
  require_count(view, "validity", mask.validity.size(), pixels);
  if (!mask.trust.empty()) require_count(view, "trust", mask.trust.size(), pixels);
  if (!mask.rim.empty()) require_count(view, "rim", mask.rim.size(), pixels);
}

void check(const StoredView& view) {
  try {
    check(view.camera);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("view " + view.name + ": " + error.what());
  }
  if (!view.photograph) throw std::invalid_argument("view " + view.name + ": photograph is null");
  require_photograph_of(view.name, view.camera, *view.photograph);
  if (!view.mask) throw std::invalid_argument("view " + view.name + ": mask is null");
  require_mask_of(view.name, view.camera, *view.mask);
}

float median_depth(const StoredView& view, float below) {
  constexpr std::size_t kStride = 16;
  std::vector<float> depths;
  std::size_t finite = 0;
  view.mask->depth.for_each([&](std::size_t, float depth) {
    if (std::isfinite(depth) && depth > 0 && depth < below && finite++ % kStride == 0) depths.push_back(depth);
  });
  return depths.empty() ? 0 : upper_median(depths);
}

StoredView make_stored_view(std::string name, const Camera& camera, std::shared_ptr<const StoredPhotograph> photograph,
                            VisibilityBuffer visible, const ValidityOptions& options, std::vector<std::uint8_t> trust) {
  if (!photograph) throw std::invalid_argument("view " + name + ": photograph is null");
  require_photograph_of(name, camera, *photograph);
  require_size(name, "visibility buffer", visible.width, visible.height, camera);
  require_count(name, "visibility buffer's depth", visible.depth.size(), pixels_of(camera));
  std::shared_ptr<const ViewMask> mask =
      make_view_mask(*photograph, std::move(visible.depth), std::move(trust), options);
  return {std::move(name), camera, std::move(photograph), std::move(mask)};
}

StoredView make_stored_view(std::string name, const Camera& camera, Photograph photograph, VisibilityBuffer visible,
                            const ValidityOptions& options, std::vector<std::uint8_t> trust) {
  return make_stored_view(std::move(name), camera, std::make_shared<const StoredPhotograph>(std::move(photograph)),
                          std::move(visible), options, std::move(trust));
}

}  // namespace lumatlas
