// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/measures/seam_contrast.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <string>

#include "mesh/repair/joined_faces.h"
#include "tools/score/measures/counted_pixels.h"

namespace lumatlas {

namespace {

constexpr std::size_t kRun = 8;        // pixels
constexpr std::size_t kBefore = 3;     // the pixel of a run before the border
constexpr float kSameSurface = 1.02F;  // neighbouring pixels of a wall seen at 75 degrees are about so far apart
constexpr double kSmoothCos = 0.866;   // 30 degrees: less than an edge of furniture, more than a scan's noise

std::uint64_t pair_of(std::uint32_t a, std::uint32_t b) {
  return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b);
}

// The pairs of different cells that share a vertex, or have one at the same place.
std::unordered_set<std::uint64_t> adjacent_cells(const Mesh& mesh, const Cells& cells) {
  std::vector<std::uint64_t> cell_at_vertex;  // vertex in the upper half, cell in the lower
  const std::vector<glm::uvec3> faces = joined_faces(mesh);
  if (cells.cell_of_face.size() != faces.size()) {
    throw std::invalid_argument("seams: cell_of_face has " + std::to_string(cells.cell_of_face.size()) +
                                " entries, must have one per face, " + std::to_string(faces.size()));
  }
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      cell_at_vertex.push_back(std::uint64_t{faces[face][corner]} << 32 | cells.cell_of_face[face]);
    }
  }
  std::sort(cell_at_vertex.begin(), cell_at_vertex.end());
  cell_at_vertex.erase(std::unique(cell_at_vertex.begin(), cell_at_vertex.end()), cell_at_vertex.end());
  std::unordered_set<std::uint64_t> pairs;
  for (std::size_t i = 0; i < cell_at_vertex.size(); ++i) {
    for (std::size_t j = i + 1; j < cell_at_vertex.size() && cell_at_vertex[j] >> 32 == cell_at_vertex[i] >> 32; ++j) {
      pairs.insert(
          pair_of(static_cast<std::uint32_t>(cell_at_vertex[i]), static_cast<std::uint32_t>(cell_at_vertex[j])));
    }
  }
  return pairs;
}

glm::dvec3 unit_normal(const Mesh& mesh, FaceId face) {
  const glm::uvec3 corners = mesh.faces[face];
  const glm::dvec3 a(mesh.positions[corners.x]);
  const glm::dvec3 normal =
      glm::cross(glm::dvec3(mesh.positions[corners.y]) - a, glm::dvec3(mesh.positions[corners.z]) - a);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : glm::dvec3(0);
}

std::int64_t square_step(const Photograph& rendering, const Photograph& photograph, std::size_t p, std::size_t q) {
  std::int64_t squares = 0;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const auto error = [&](std::size_t pixel) {
      return int{rendering.rgb[3 * pixel + channel]} - int{photograph.rgb[3 * pixel + channel]};
    };
    const std::int64_t step = error(p) - error(q);
    squares += step * step;
  }
  return squares;
}

}  // namespace

SeamMeter::SeamMeter(const Mesh& mesh, const Cells& cells)
    : mesh_(mesh), cells_(cells), adjacent_(adjacent_cells(mesh, cells)) {}

bool SeamMeter::neighbours(std::uint32_t a, std::uint32_t b) const {
  return adjacent_.contains(pair_of(a, b));
}

// Returns whether the run of pixels from `first` on shows one smooth surface and its cell changes in the middle and
// only there.
bool SeamMeter::crosses_border(const VisibilityBuffer& visible, std::size_t first, std::size_t stride) const {
  const auto face = [&](std::size_t i) { return visible.face[first + i * stride]; };
  if (face(kBefore) == FaceId::none || face(kBefore + 1) == FaceId::none) return false;
  const CellId before = cells_.cell_of_face[face(kBefore)];
  const CellId after = cells_.cell_of_face[face(kBefore + 1)];
  if (before == after || !neighbours(before, after)) return false;
  const glm::dvec3 normal = unit_normal(mesh_, face(kBefore));
  for (std::size_t i = 0; i < kRun; ++i) {
    if (face(i) == FaceId::none || cells_.cell_of_face[face(i)] != (i <= kBefore ? before : after)) return false;
    if (glm::dot(unit_normal(mesh_, face(i)), normal) < kSmoothCos) return false;
    if (i == 0) continue;
    const auto [near, far] = std::minmax(visible.depth[first + (i - 1) * stride], visible.depth[first + i * stride]);
    if (far > kSameSurface * near) return false;
  }
  return true;
}

void SeamMeter::add(const VisibilityBuffer& visible, const Photograph& rendering, const Photograph& photograph) {
  if (visible.width != photograph.width || visible.height != photograph.height) {
    throw std::invalid_argument("seams: the visibility buffer must be as large as the pictures");
  }
  check_entries("visible.depth", visible.depth.size(), std::size_t{visible.width} * visible.height);
  check_entries("visible.face", visible.face.size(), visible.depth.size());
  for (const FaceId face : visible.face) {
    if (face == FaceId::none || face < mesh_.faces.size()) continue;
    throw std::invalid_argument("seams: the visibility buffer shows face " + std::to_string(face) +
                                ", must be below the number of faces, " + std::to_string(mesh_.faces.size()));
  }
  const CountedPixels counted = counted_pixels(rendering, photograph, {});
  const auto look_at = [&](std::size_t first, std::size_t stride) {
    if (!crosses_border(visible, first, stride)) return;
    for (std::size_t i = 0; i < kRun; ++i) {
      if (counted[first + i * stride] == 0) return;
    }
    const auto step = [&](std::size_t i) {
      return square_step(rendering, photograph, first + i * stride, first + (i + 1) * stride);
    };
    ++borders_;
    across_ += step(kBefore);
    beside_ += step(0) + step(kRun - 2);
  };
  const std::size_t width = visible.width;
  for (std::size_t y = 0; y < visible.height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      if (x + kRun <= width) look_at(y * width + x, 1);
      if (y + kRun <= visible.height) look_at(y * width + x, width);
    }
  }
}

double SeamMeter::contrast() const {
  if (borders_ == 0) return std::numeric_limits<double>::quiet_NaN();
  const double pairs = 3 * static_cast<double>(borders_);
  const double excess = (static_cast<double>(across_) - static_cast<double>(beside_) / 2) / pairs;
  return std::copysign(std::sqrt(std::abs(excess)), excess);
}

}  // namespace lumatlas
