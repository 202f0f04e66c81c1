// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/cells/spreading.h"

#include <cstdint>
#include <utility>

namespace lumatlas {

namespace {

class Spreading {
 public:
  Spreading(std::span<const glm::uvec3> faces, const VertexFaces& around, std::vector<glm::vec4>& values)
      : faces_(faces), around_(around), values_(values), reached_(values.size(), 0) {
    for (std::uint32_t vertex = 0; vertex < values.size(); ++vertex) {
      if (values[vertex].w > 0) reach_around(vertex);
    }
  }

  // Gives each vertex next to those that have a value the mean of these; false if there is none.
  bool next_ring() {
    const std::vector<std::uint32_t> ring = std::exchange(ring_, {});
    std::vector<glm::vec4> means;
    means.reserve(ring.size());
    for (const std::uint32_t vertex : ring) means.push_back(mean_around(vertex));
    for (std::size_t i = 0; i < ring.size(); ++i) values_[ring[i]] = means[i];
    for (const std::uint32_t vertex : ring) reach_around(vertex);
    return !ring.empty();
  }

 private:
  void reach_around(std::uint32_t vertex) {
    for (const std::uint32_t face : around_[vertex]) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t neighbour = faces_[face][corner];
        if (values_[neighbour].w > 0 || reached_[neighbour]) continue;
        reached_[neighbour] = 1;
        ring_.push_back(neighbour);
      }
    }
  }

  [[nodiscard]] glm::vec4 mean_around(std::uint32_t vertex) const {
    glm::vec4 sum(0);
    for (const std::uint32_t face : around_[vertex]) {
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec4& value = values_[faces_[face][corner]];
        if (value.w > 0) sum += glm::vec4(glm::vec3(value) / value.w, 1);
      }
    }
    return sum;
  }

  std::span<const glm::uvec3> faces_;
  const VertexFaces& around_;
  std::vector<glm::vec4>& values_;
  std::vector<std::uint8_t> reached_;
  std::vector<std::uint32_t> ring_;  // vertices without a value that have a neighbour with one
};

}  // namespace

void spread(std::span<const glm::uvec3> faces, const VertexFaces& around, std::vector<glm::vec4>& values) {
  Spreading spreading(faces, around, values);
  while (spreading.next_ring()) {
  }
}

}  // namespace lumatlas
