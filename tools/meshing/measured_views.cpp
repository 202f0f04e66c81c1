// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/measured_views.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace lumatlas {
namespace {

constexpr int kLeastAgreeing = 2;            // photographs that confirm a depth
constexpr float kDeviations = 4;             // deviations of a measured depth, and
constexpr float kLeastDistance = 0.05F;      // share of the depth, up to which depths count as the same
constexpr std::size_t kLeastViewPixels = 8;  // least size of a group in a view that counts
constexpr std::size_t kLeastViews = 3;       // from different directions
constexpr double kOtherDirection = 0.9976;   // cosine of 4 degrees
constexpr double kLeastParallaxPx = 2;       // between two points, to tell their colours apart

std::size_t pixel_at(const glm::dvec2& at, const Camera& camera) {
  return static_cast<std::size_t>(at.y) * camera.width + static_cast<std::size_t>(at.x);
}

double squared_difference(const glm::vec3& a, const glm::vec3& b) {
  const glm::dvec3 difference(a - b);
  return glm::dot(difference, difference);
}

}  // namespace

bool MeasuredView::is_confirmed(std::size_t pixel) const {
  return valid[pixel] != 0 && measured.depth[pixel] > 0 && std::popcount(measured.agreeing[pixel]) >= kLeastAgreeing;
}

float MeasuredView::same_depth(std::size_t pixel) const {
  return std::max(kDeviations * measured.deviation[pixel], kLeastDistance * measured.depth[pixel]);
}

glm::dvec3 MeasuredView::point_at(std::size_t pixel, float depth) const {
  const Camera& camera = measured.camera;
  const std::size_t x = pixel % camera.width, y = pixel / camera.width;
  return camera.center() + double{depth} * camera.ray({static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5});
}

std::optional<glm::dvec2> MeasuredView::image_of(const glm::dvec3& point) const {
  const Camera& camera = measured.camera;
  const glm::dvec3 cam = camera.cam_from_world(point);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 at = camera.image_from_cam(cam);
  if (!(at.x >= 1 && at.y >= 1 && at.x < camera.width - 1.0 && at.y < camera.height - 1.0)) return std::nullopt;
  return at;
}

std::optional<glm::dvec2> MeasuredView::where_measured(const glm::dvec3& point) const {
  const std::optional<glm::dvec2> at = image_of(point);
  if (!at) return std::nullopt;
  const std::size_t pixel = pixel_at(*at, measured.camera);
  const auto depth = static_cast<float>(measured.camera.cam_from_world(point).z);
  const bool same = measured.depth[pixel] > 0 && std::abs(measured.depth[pixel] - depth) <= same_depth(pixel);
  return same && valid[pixel] != 0 ? at : std::nullopt;
}

std::optional<glm::dvec2> MeasuredView::where_seen(const glm::dvec3& point, const VisibilityBuffer& visible) const {
  const std::optional<glm::dvec2> at = image_of(point);
  if (!at) return std::nullopt;
  const std::size_t pixel = pixel_at(*at, measured.camera);
  const double depth = measured.camera.cam_from_world(point).z;
  const bool same = std::abs(double{visible.depth[pixel]} - depth) < double{kLeastDistance} * depth;
  return visible.face[pixel] != FaceId::none && same && valid[pixel] != 0 ? at : std::nullopt;
}

glm::vec3 MeasuredView::color_at(const glm::dvec2& at) const {
  const std::size_t width = measured.camera.width;
  const glm::dvec2 corner = glm::floor(at - 0.5);
  const glm::vec2 share(at - 0.5 - corner);
  const std::size_t pixel = static_cast<std::size_t>(corner.y) * width + static_cast<std::size_t>(corner.x);
  return glm::mix(glm::mix(color[pixel], color[pixel + 1], share.x),
                  glm::mix(color[pixel + width], color[pixel + width + 1], share.x), share.y);
}

FaceGroups::FaceGroups(const Mesh& mesh, const std::vector<bool>& wanted) : mesh_(mesh), sets_(mesh.positions.size()) {
  for (std::size_t face = 0; face < wanted.size(); ++face) {
    if (!wanted[face]) continue;
    sets_.union_set(mesh.faces[face].x, mesh.faces[face].y);
    sets_.union_set(mesh.faces[face].x, mesh.faces[face].z);
  }
}

std::uint32_t FaceGroups::of(std::size_t face) {
  return static_cast<std::uint32_t>(sets_.find_set(mesh_.faces[face].x));
}

void PixelGroup::add(const FacePixel& pixel, const Mesh& mesh) {
  sum += glm::dvec3(mesh.positions[mesh.faces[pixel.face].x]);
  pixels.push_back(pixel);
}

ColorErrors& ColorErrors::operator+=(const ColorErrors& other) {
  nearer += other.nearer;
  farther += other.farther;
  compared += other.compared;
  return *this;
}

bool is_seen_around(const PixelGroup& group, std::span<const MeasuredView> views) {
  std::vector<std::size_t> pixels(views.size(), 0);
  for (const FacePixel& at : group.pixels) ++pixels[at.view];
  const glm::dvec3 middle = group.sum / static_cast<double>(group.pixels.size());
  std::vector<glm::dvec3> directions;
  for (std::size_t view = 0; view < pixels.size(); ++view) {
    if (pixels[view] < kLeastViewPixels) continue;
    const glm::dvec3 direction = glm::normalize(views[view].measured.camera.center() - middle);
    const bool is_new = std::all_of(directions.begin(), directions.end(), [&](const glm::dvec3& other) {
      return glm::dot(direction, other) < kOtherDirection;
    });
    if (is_new) directions.push_back(direction);
  }
  return directions.size() >= kLeastViews;
}

void compare_colors(const MeasuredView& view, const std::optional<glm::dvec2>& nearer,
                    const std::optional<glm::dvec2>& farther, const glm::vec3& color, ColorErrors& errors) {
  if (!nearer || !farther || glm::distance(*nearer, *farther) < kLeastParallaxPx) return;
  errors.nearer += squared_difference(view.color_at(*nearer), color);
  errors.farther += squared_difference(view.color_at(*farther), color);
  ++errors.compared;
}

}  // namespace lumatlas
