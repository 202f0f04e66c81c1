// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/live/surface_bend.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::uint32_t kGlancePixels = 48;  // longer side
constexpr int kSmoothingRounds = 2;          // over neighbouring cells
constexpr double kBlendRadius = 2;           // cell sizes from a cell's centroid within which it moves vertices
constexpr double kLeastShare = 1e-6;         // of a vertex's own cell, so that each vertex has a motion

// Sums rigid motions of the world by their weights; the mean is affine.
struct MotionSum {
  glm::dmat3 turn{0.0};
  glm::dvec3 shift{0.0};
  double weight = 0;

  void add(const MotionSum& other, double times) {
    turn += times * other.turn;
    shift += times * other.shift;
    weight += times * other.weight;
  }
  [[nodiscard]] glm::dvec3 mean_at(const glm::dvec3& place) const { return (turn * place + shift) / weight; }
};

// Returns the motion from where the frame's camera is shown to where it is wanted, with a weight of 1.
MotionSum motion_of(const BendingFrame& frame) {
  const glm::dmat3 world_from_wanted = glm::transpose(frame.wanted.cam_from_world_rotation);
  return {world_from_wanted * frame.shown.cam_from_world_rotation,
          world_from_wanted * (frame.shown.cam_from_world_translation - frame.wanted.cam_from_world_translation), 1};
}

// Returns a place on the surface for each cell: the middle of that of its faces that is nearest to its centroid.
std::vector<glm::dvec3> places_of(const Mesh& mesh, const Cells& cells) {
  std::vector<glm::dvec3> places(cells.cells.size());
  std::vector<double> nearest(places.size(), std::numeric_limits<double>::infinity());
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    const CellId cell = cells.cell_of_face[face];
    const glm::uvec3& corners = mesh.faces[face];
    const glm::dvec3 middle = (glm::dvec3(mesh.positions[corners.x]) + glm::dvec3(mesh.positions[corners.y]) +
                               glm::dvec3(mesh.positions[corners.z])) /
                              3.0;
    const double distance = glm::distance(middle, cells.cells[cell].centroid);
    if (!(distance < nearest[cell])) continue;
    nearest[cell] = distance;
    places[cell] = middle;
  }
  return places;
}

// Returns how much the frame counts for a place; 0 if it has measured another one.
double weight_of(const BendingFrame& frame, const Camera& small, const glm::dvec3& place, double reach) {
  const glm::dvec3 cam = small.cam_from_world(place);
  if (!(cam.z > 0)) return 0;
  const glm::dvec2 pixel = small.image_from_cam(cam);
  if (!(pixel.x >= 0 && pixel.y >= 0 && pixel.x < small.width && pixel.y < small.height)) return 0;
  const RoundedDepth& depth = frame.glance->depth;
  const std::size_t index =
      static_cast<std::size_t>(pixel.y) * small.width + static_cast<std::size_t>(std::floor(pixel.x));
  if (depth.steps[index] == 0) return 0;
  // Within a pixel of the small picture, a surface at 45 degrees is this much nearer or farther.
  const double tolerance = reach + cam.z / small.fx;
  const double off = (depth.unit * depth.steps[index] - cam.z) / tolerance;
  return std::abs(off) < 1 ? (1 - off * off) / (cam.z * cam.z) : 0;
}

// Returns by cell the sum of the motions of the frames that have measured it.
std::vector<MotionSum> measured_motions(std::span<const glm::dvec3> places, std::span<const BendingFrame> frames,
                                        double reach) {
  std::vector<Camera> small;
  std::vector<MotionSum> motions;
  for (const BendingFrame& frame : frames) {
    small.push_back(frame.shown.scaled_to(frame.glance->width, frame.glance->height));
    motions.push_back(motion_of(frame));
  }
  std::vector<MotionSum> sums(places.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums.size()), [&](const auto& range) {
    for (std::size_t cell = range.begin(); cell < range.end(); ++cell) {
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const double weight = weight_of(frames[i], small[i], places[cell], reach);
        if (weight > 0) sums[cell].add(motions[i], weight);
      }
    }
  });
  return sums;
}

// Returns for each vertex the cell of the first face that has it; CellId::none: no face has it.
std::vector<CellId> cell_of_vertex(const Mesh& mesh, const Cells& cells) {
  std::vector<CellId> own(mesh.positions.size(), CellId::none);
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) {
      CellId& cell = own[mesh.faces[face][corner]];
      if (cell == CellId::none) cell = cells.cell_of_face[face];
    }
  }
  return own;
}

// Lists by cell the cells that share a vertex with it.
struct CellNeighbors {
  std::vector<std::size_t> first;  // by cell, where its neighbours begin; and their number at the end
  std::vector<CellId> cells;

  [[nodiscard]] std::span<const CellId> of(std::size_t cell) const {
    return std::span(cells).subspan(first[cell], first[cell + 1] - first[cell]);
  }
};

CellNeighbors neighbors_of(const Mesh& mesh, const Cells& cells, std::span<const CellId> own) {
  std::vector<std::pair<CellId, CellId>> pairs;
  for (FaceId face{0}; face < mesh.faces.size(); ++face) {
    const CellId cell = cells.cell_of_face[face];
    for (int corner = 0; corner < 3; ++corner) {
      const CellId other = own[mesh.faces[face][corner]];
      if (other == cell) continue;
      pairs.emplace_back(cell, other);
      pairs.emplace_back(other, cell);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  CellNeighbors neighbors;
  neighbors.first.assign(cells.cells.size() + 1, 0);
  for (const auto& [cell, other] : pairs) {
    ++neighbors.first[cell + 1];
    neighbors.cells.push_back(other);
  }
  for (std::size_t cell = 0; cell < cells.cells.size(); ++cell) neighbors.first[cell + 1] += neighbors.first[cell];
  return neighbors;
}

void smooth(const CellNeighbors& neighbors, std::vector<MotionSum>& motions) {
  std::vector<MotionSum> smoothed = motions;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, motions.size()), [&](const auto& range) {
    for (std::size_t cell = range.begin(); cell < range.end(); ++cell) {
      for (const CellId other : neighbors.of(cell)) smoothed[cell].add(motions[other], 1);
    }
  });
  motions = std::move(smoothed);
}

// Gives cells without a motion the mean of their neighbours', ring by ring.
void spread(const CellNeighbors& neighbors, std::vector<MotionSum>& motions) {
  std::vector<std::size_t> still;
  for (std::size_t cell = 0; cell < motions.size(); ++cell) {
    if (motions[cell].weight == 0) still.push_back(cell);
  }
  for (std::vector<std::pair<std::size_t, MotionSum>> found; !still.empty(); found.clear()) {
    for (const std::size_t cell : still) {
      MotionSum sum;
      for (const CellId other : neighbors.of(cell)) {
        if (motions[other].weight > 0) sum.add(motions[other], 1 / motions[other].weight);
      }
      if (sum.weight > 0) found.emplace_back(cell, sum);
    }
    if (found.empty()) return;
    for (const auto& [cell, sum] : found) motions[cell] = sum;
    std::erase_if(still, [&](std::size_t cell) { return motions[cell].weight > 0; });
  }
}

}  // namespace

DepthGlance depth_glance(const Camera& camera, const RoundedDepth& depth) {
  const Camera small = camera.shrunk_to(kGlancePixels);
  DepthGlance glance{small.width, small.height, {depth.unit, {}}};
  glance.depth.steps.reserve(std::size_t{small.width} * small.height);
  for (std::uint32_t y = 0; y < small.height; ++y) {
    const std::size_t row = (2 * std::size_t{y} + 1) * camera.height / (2 * std::size_t{small.height});
    for (std::uint32_t x = 0; x < small.width; ++x) {
      const std::size_t column = (2 * std::size_t{x} + 1) * camera.width / (2 * std::size_t{small.width});
      glance.depth.steps.push_back(depth.steps[row * camera.width + column]);
    }
  }
  return glance;
}

std::vector<glm::vec3> bent_positions(const Mesh& mesh, const Cells& cells, std::span<const BendingFrame> frames,
                                      double reach, double least) {
  const std::vector<CellId> own = cell_of_vertex(mesh, cells);
  const CellNeighbors neighbors = neighbors_of(mesh, cells, own);
  std::vector<MotionSum> motions = measured_motions(places_of(mesh, cells), frames, reach);
  for (int round = 0; round < kSmoothingRounds; ++round) smooth(neighbors, motions);
  spread(neighbors, motions);
  std::vector<glm::vec3> positions = mesh.positions;
  const double radius = kBlendRadius * cells.size;
  const auto bend = [&](glm::vec3& position, CellId cell) {
    const glm::dvec3 place(position);
    const auto share_of = [&](CellId other) {
      const double share = 1 - std::pow(glm::distance(place, cells.cells[other].centroid) / radius, 2);
      return share > 0 ? share * share : 0;
    };
    double total = std::max(share_of(cell), kLeastShare);
    glm::dvec3 sum = total * motions[cell].mean_at(place);
    for (const CellId other : neighbors.of(cell)) {
      const double share = share_of(other);
      if (!(share > 0 && motions[other].weight > 0)) continue;
      sum += share * motions[other].mean_at(place);
      total += share;
    }
    const glm::dvec3 moved = sum / total;
    if (glm::distance(moved, place) >= least) position = glm::vec3(moved);
  };
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), 1 << 12), [&](const auto& range) {
    for (std::size_t vertex = range.begin(); vertex < range.end(); ++vertex) {
      const CellId cell = own[vertex];
      if (cell != CellId::none && motions[cell].weight > 0) bend(positions[vertex], cell);
    }
  });
  return positions;
}

}  // namespace lumatlas
