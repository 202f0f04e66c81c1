// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/slivers.h"

#include <algorithm>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <queue>
#include <utility>

#include "mesh/base/id.h"

namespace lumatlas {

namespace {

// Areas are in squares of the cell size. Clusters below the first are slivers, and look for a neighbour to merge with;
// those below the second are crumbs, smaller than what noise folds in a scan, whichever way they face.
constexpr double kSliverArea = 0.35;
constexpr double kCrumbArea = 0.2;
// Limits of a merged cluster: its area, its radius in cell sizes, and its flatness (Cluster::flatness) where the
// smaller part is a sliver (0.8 is a fold of two equal parts by 74 degrees) or a crumb.
constexpr double kLargestArea = 1.8;
constexpr double kLargestRadius = 1.0;
constexpr double kLeastFlatness = 0.8;
constexpr double kCrumbFlatness = 0.3;

struct Cluster {
  std::vector<FaceId> faces;
  glm::dvec3 moment{0.0};  // area times centroid
  glm::dvec3 normal{0.0};  // area times normal
  double area = 0;

  [[nodiscard]] glm::dvec3 centroid() const { return area > 0 ? moment / area : moment; }
  // 1 for a plane, 0 where the normals cancel.
  [[nodiscard]] double flatness() const { return area > 0 ? glm::length(normal) / area : 1; }
};

class SliverMerger {
 public:
  SliverMerger(const ClusterMesh& surface, double size, std::vector<std::uint32_t>& labels, std::uint32_t first)
      : surface_(surface), size_(size), labels_(labels), first_(first) {}

  void run(const CancelCheck& cancel_check) {
    constexpr std::size_t kSliversBetweenChecks = 1024;
    CancelCheckEvery now_and_then(cancel_check, kSliversBetweenChecks);
    gather();
    Queue slivers;
    for (std::uint32_t i = 0; i < clusters_.size(); ++i) enqueue_if_small(i, slivers);
    while (!slivers.empty()) {
      const auto [area, index] = slivers.top();
      slivers.pop();
      now_and_then.step();
      if (clusters_[index].faces.empty() || clusters_[index].area != area) continue;  // merged since it was queued
      const std::uint32_t host = best_host(index);
      if (host == kNoCluster) continue;
      const bool stays = index < first_;
      merge(stays ? host : index, stays ? index : host);
      enqueue_if_small(stays ? index : host, slivers);
    }
  }

 private:
  using Queue = std::priority_queue<std::pair<double, std::uint32_t>, std::vector<std::pair<double, std::uint32_t>>,
                                    std::greater<>>;

  void gather() {
    if (!labels_.empty()) clusters_.resize(*std::max_element(labels_.begin(), labels_.end()) + 1);
    for (FaceId face{0}; face < labels_.size(); ++face) {
      Cluster& cluster = clusters_[labels_[face]];
      const double area = surface_[face].area;
      cluster.faces.push_back(face);
      cluster.moment += area * glm::dvec3(surface_[face].centroid);
      cluster.normal += area * glm::dvec3(surface_[face].normal);
      cluster.area += area;
    }
  }

  void enqueue_if_small(std::uint32_t index, Queue& slivers) const {
    if (clusters_[index].area < kSliverArea * size_ * size_) slivers.emplace(clusters_[index].area, index);
  }

  [[nodiscard]] std::vector<std::uint32_t> neighbors(std::uint32_t index) const {
    std::vector<std::uint32_t> found;
    for (const FaceId face : clusters_[index].faces) {
      surface_.for_each_neighbor(face, [&](FaceId other) {
        if (labels_[other] != index) found.push_back(labels_[other]);
      });
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
  }

  [[nodiscard]] Cluster sums_of(const Cluster& a, const Cluster& b) const {
    return {{}, a.moment + b.moment, a.normal + b.normal, a.area + b.area};
  }

  [[nodiscard]] double radius_around(const glm::dvec3& centroid, const Cluster& cluster) const {
    double radius = 0;
    for (const FaceId face : cluster.faces) {
      radius = std::max(radius, glm::distance(centroid, glm::dvec3(surface_[face].centroid)));
    }
    return radius;
  }

  // The neighbour with which the sliver makes the most compact and flat cluster, or kNoCluster if there is none that
  // fits. At least one of the two is a cluster that may be given to another.
  [[nodiscard]] std::uint32_t best_host(std::uint32_t sliver) const {
    std::uint32_t best = kNoCluster;
    double least_cost = std::numeric_limits<double>::infinity();
    const bool is_crumb = clusters_[sliver].area < kCrumbArea * size_ * size_;
    const double least_flatness = is_crumb ? kCrumbFlatness : kLeastFlatness;
    for (const std::uint32_t host : neighbors(sliver)) {
      if (sliver < first_ && host < first_) continue;
      const Cluster merged = sums_of(clusters_[sliver], clusters_[host]);
      if (merged.area > kLargestArea * size_ * size_ || merged.flatness() < least_flatness) continue;
      const glm::dvec3 centroid = merged.centroid();
      const double radius =
          std::max(radius_around(centroid, clusters_[sliver]), radius_around(centroid, clusters_[host])) / size_;
      const double cost = radius + 2 * (1 - merged.flatness());
      if (radius > kLargestRadius || cost >= least_cost) continue;
      least_cost = cost;
      best = host;
    }
    return best;
  }

  void merge(std::uint32_t from, std::uint32_t into) {
    Cluster merged = sums_of(clusters_[from], clusters_[into]);
    merged.faces = std::move(clusters_[into].faces);
    for (const FaceId face : clusters_[from].faces) {
      labels_[face] = into;
      merged.faces.push_back(face);
    }
    clusters_[from] = {};
    clusters_[into] = std::move(merged);
  }

  const ClusterMesh& surface_;
  double size_;
  std::vector<std::uint32_t>& labels_;
  std::uint32_t first_;  // the lowest label of a cluster that may be given to another
  std::vector<Cluster> clusters_;
};

}  // namespace

void merge_slivers(const ClusterMesh& surface, double size, std::vector<std::uint32_t>& labels, std::uint32_t first,
                   const CancelCheck& cancel_check) {
  SliverMerger(surface, size, labels, first).run(cancel_check);
}

}  // namespace lumatlas
