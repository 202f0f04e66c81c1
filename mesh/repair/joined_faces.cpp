// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/joined_faces.h"

#include <bit>
#include <cstddef>
#include <cstdint>

#include "mesh/repair/place_hash.h"

namespace lumatlas {

namespace {

// The vertices of which each is the first at its place, found by their places.
class FirstAtPlace {
 public:
  explicit FirstAtPlace(const std::vector<glm::vec3>& places)
      : places_(places), entries_(std::bit_ceil(2 * places.size() + 1), kEmpty) {}

  // Returns the vertex that was added first at the place of this one: itself, which is added then, if there was none.
  std::uint32_t add(std::uint32_t vertex) {
    if (places_[vertex] != places_[vertex]) return vertex;  // is no number, which equals nothing
    for (std::size_t i = hash_of_place(places_[vertex]);; ++i) {
      std::uint32_t& entry = entries_[i & (entries_.size() - 1)];
      if (entry == kEmpty) entry = vertex;
      if (places_[entry] == places_[vertex]) return entry;
    }
  }

 private:
  static constexpr std::uint32_t kEmpty = ~0U;

  const std::vector<glm::vec3>& places_;
  std::vector<std::uint32_t> entries_;
};

}  // namespace

std::vector<glm::uvec3> joined_faces(const Mesh& mesh) {
  check_faces(mesh);
  FirstAtPlace known(mesh.positions);
  std::vector<std::uint32_t> first(mesh.positions.size());
  for (std::uint32_t vertex = 0; vertex < first.size(); ++vertex) first[vertex] = known.add(vertex);
  std::vector<glm::uvec3> faces;
  faces.reserve(mesh.faces.size());
  for (const glm::uvec3& face : mesh.faces) faces.emplace_back(first[face.x], first[face.y], first[face.z]);
  return faces;
}

}  // namespace lumatlas
