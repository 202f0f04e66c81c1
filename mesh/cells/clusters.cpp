// SPDX-License-Identifier: GPL-3.0-or-later
// Variational clustering in the manner of Cohen-Steiner et al., "Variational Shape Approximation", 2004: grow all
// clusters at once from their seeds, move each seed to the middle of its cluster, repeat. Departures: the cost is
// mostly a distance, for compact cells, and the seeds come from dart throwing, so that their number follows from the
// size.
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "mesh/base/id.h"
#include "mesh/cells/cluster_mesh.h"
#include "mesh/cells/partitions.h"
#include "mesh/repair/slivers.h"

namespace lumatlas {

namespace {

constexpr std::size_t kFacesBetweenChecks = 1 << 16;  // some ten milliseconds

// Position and direction of a cluster. Every cluster owns its seed face.
struct Center {
  FaceId seed;
  glm::vec3 position;
  glm::vec3 normal;
};

struct Metric {
  float per_size;  // 1 / cell size
  float normal_weight;

  // See CellOptions::normal_weight.
  [[nodiscard]] float cost(const ClusterMesh& surface, const Center& center, FaceId face) const {
    const float turn = std::max(0.0f, 1 - glm::dot(surface[face].normal, center.normal));  // rounding can exceed 1
    return glm::distance(surface[face].centroid, center.position) * per_size + normal_weight * turn;
  }
};

Center center_at(const ClusterMesh& surface, FaceId face) {
  return {face, surface[face].centroid, surface[face].normal};
}

// The last step of splitmix64: a permutation of the integers that looks random.
std::uint64_t scramble(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

std::vector<FaceId> shuffled_faces(std::size_t faces) {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed(faces);
  for (FaceId face{0}; face < faces; ++face) keyed[face] = {scramble(face), face};
  tbb::parallel_sort(keyed);
  std::vector<FaceId> order(faces);
  std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& entry) { return FaceId{entry.second}; });
  return order;
}

// Maximal dart throwing by the metric, along the surface: no seed is within kSpacing of an earlier one, and every face
// is within kSpacing of a seed of its own component, so that both sides of a thin wall get theirs.
class Seeding {
 public:
  Seeding(const ClusterMesh& surface, const Metric& metric, const CancelCheck& cancel_check)
      : surface_(surface),
        metric_(metric),
        cancel_check_(cancel_check, kFacesBetweenChecks),
        covered_(surface.size(), 0),
        visitor_(surface.size(), kNoCluster) {}

  [[nodiscard]] std::vector<Center> run() {
    for (const FaceId face : shuffled_faces(surface_.size())) {
      if (covered_[face]) continue;
      centers_.push_back(center_at(surface_, face));
      cover_around(face);
    }
    return std::move(centers_);
  }

 private:
  // Random sequential discs of radius r / 2 cover 54.7% of the plane: an area of 1.436 r^2 for each, here 1.
  static constexpr float kSpacing = 0.834f;

  // Extent of a face beyond its centroid, in cell sizes: without it, cells of few faces would come out too large.
  [[nodiscard]] float reach(FaceId face) const {
    constexpr float kReach = 0.2f;  // share of the root of its area; measured
    return kReach * std::sqrt(surface_[face].area) * metric_.per_size;
  }

  void cover_around(FaceId seed) {
    const auto visit = static_cast<std::uint32_t>(centers_.size() - 1);
    visitor_[seed] = visit;
    stack_.assign(1, seed);
    while (!stack_.empty()) {
      const FaceId face = stack_.back();
      stack_.pop_back();
      cancel_check_.step();
      covered_[face] = 1;
      surface_.for_each_neighbor(face, [&](FaceId next) {
        if (visitor_[next] == visit) return;
        visitor_[next] = visit;
        if (metric_.cost(surface_, centers_.back(), next) + reach(next) < kSpacing) stack_.push_back(next);
      });
    }
  }

  const ClusterMesh& surface_;
  const Metric& metric_;
  CancelCheckEvery cancel_check_;
  std::vector<Center> centers_;
  std::vector<std::uint8_t> covered_;
  std::vector<std::uint32_t> visitor_;  // the last seed that came by
  std::vector<FaceId> stack_;
};

// A monotone priority queue: costs in steps of 1/256 of a cell size, first in first out within a step.
class BucketQueue {
 public:
  struct Entry {
    FaceId face;
    std::uint32_t cluster;
  };
  void push(float cost, const Entry& entry) {
    const float step = cost * kStepsPerSize;
    const std::size_t bucket = step < kBuckets - 1 ? static_cast<std::size_t>(step) : kBuckets - 1;  // NaN comes last
    buckets_[std::max(bucket, current_)].push_back(entry);
  }
  // False when nothing is left.
  bool pop(Entry& entry) {
    while (next_ == buckets_[current_].size()) {
      if (current_ + 1 == kBuckets) return false;
      std::vector<Entry>().swap(buckets_[current_++]);
      next_ = 0;
    }
    entry = buckets_[current_][next_++];
    return true;
  }
  // The face of the entry that will be popped after `ahead` others, or of a later one of these if that is not known.
  [[nodiscard]] FaceId upcoming_face(std::size_t ahead) const {
    const std::vector<Entry>& bucket = buckets_[current_];
    return bucket[std::min(next_ + ahead, bucket.size() - 1)].face;
  }

 private:
  static constexpr float kStepsPerSize = 256;
  static constexpr std::size_t kBuckets = 16 * 256;  // whatever costs more comes last, in the order it was found
  std::vector<std::vector<Entry>> buckets_{kBuckets};
  std::size_t current_ = 0;
  std::size_t next_ = 0;
};

// Gives each face to the cluster that reaches it over faces of least cost (the dearest on the way counts), so that
// every cluster is connected.
std::vector<std::uint32_t> grow(const ClusterMesh& surface, const std::vector<Center>& centers, const Metric& metric,
                                const CancelCheck& cancel_check) {
  CancelCheckEvery now_and_then(cancel_check, kFacesBetweenChecks);
  std::vector<std::uint32_t> labels(surface.size(), kNoCluster);
  BucketQueue queue;
  for (std::uint32_t cluster = 0; cluster < centers.size(); ++cluster) queue.push(0, {centers[cluster].seed, cluster});
  for (BucketQueue::Entry entry{}; queue.pop(entry);) {
    surface.prefetch_neighbors(queue.upcoming_face(12));
    const FaceId soon = queue.upcoming_face(6);
    if (labels[soon] == kNoCluster) {
      surface.for_each_neighbor(soon, [&](FaceId neighbor) { __builtin_prefetch(&surface[neighbor]); });
    }
    if (labels[entry.face] != kNoCluster) continue;
    labels[entry.face] = entry.cluster;
    now_and_then.step();
    surface.for_each_neighbor(entry.face, [&](FaceId next) {
      if (labels[next] != kNoCluster) return;
      queue.push(metric.cost(surface, centers[entry.cluster], next), {next, entry.cluster});
    });
  }
  return labels;
}

// Moves each centre to its cluster's centroid and mean normal, and its seed to the face of least cost from there.
void recenter(const ClusterMesh& surface, const std::vector<std::uint32_t>& labels, const Metric& metric,
              std::vector<Center>& centers) {
  struct Sums {
    glm::dvec3 position{0.0};
    glm::dvec3 normal{0.0};
    double area = 0;
  };
  std::vector<Sums> sums(centers.size());
  for (FaceId face{0}; face < surface.size(); ++face) {
    Sums& sum = sums[labels[face]];
    const double area = surface[face].area;
    sum.position += area * glm::dvec3(surface[face].centroid);
    sum.normal += area * glm::dvec3(surface[face].normal);
    sum.area += area;
  }
  for (std::size_t cluster = 0; cluster < centers.size(); ++cluster) {
    const Sums& sum = sums[cluster];
    const double length = glm::length(sum.normal);
    if (sum.area > 0) centers[cluster].position = sum.position / sum.area;
    if (length > 0) centers[cluster].normal = sum.normal / length;
  }
  std::vector<float> least(centers.size(), std::numeric_limits<float>::infinity());
  for (FaceId face{0}; face < surface.size(); ++face) {
    const std::uint32_t cluster = labels[face];
    const float cost = metric.cost(surface, centers[cluster], face);
    if (cost >= least[cluster]) continue;
    least[cluster] = cost;
    centers[cluster].seed = face;
  }
}

}  // namespace

std::vector<std::uint32_t> cluster_labels(const Mesh& mesh, std::span<const FaceGeometry> geometry, double size,
                                          double normal_weight, const CancelCheck& cancel_check) {
  constexpr int kLloydSteps = 3;
  const ClusterMesh surface(mesh, geometry, size);
  check_cancelled(cancel_check);
  constexpr double kMostWeight = 1e30;  // more would be no float, and means no more
  const Metric metric{static_cast<float>(1 / size), static_cast<float>(std::min(normal_weight, kMostWeight))};
  std::vector<Center> centers = Seeding(surface, metric, cancel_check).run();
  std::vector<std::uint32_t> labels = grow(surface, centers, metric, cancel_check);
  for (int step = 0; step < kLloydSteps; ++step) {
    check_cancelled(cancel_check);
    recenter(surface, labels, metric, centers);
    labels = grow(surface, centers, metric, cancel_check);
  }
  check_cancelled(cancel_check);
  merge_slivers(surface, size, labels, 0, cancel_check);
  return labels;
}

}  // namespace lumatlas
