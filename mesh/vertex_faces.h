// SPDX-License-Identifier: GPL-3.0-or-later
// Internal: the faces around each vertex of any triangle list, manifold or not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lumatlas {

class VertexFaces {
 public:
  // `faces` is a range of triangles t with vertices t[0], t[1], t[2] below `vertices`.
  template <typename Faces>
  VertexFaces(std::size_t vertices, const Faces& faces) : end_(vertices + 1, 0), faces_(3 * faces.size()) {
    for (const auto& face : faces) {
      for (int corner = 0; corner < 3; ++corner) ++end_[face[corner] + 1];
    }
    for (std::size_t vertex = 1; vertex <= vertices; ++vertex) end_[vertex] += end_[vertex - 1];
    // Filling moves each begin to the end of its list, so that end_[v] is where v's list ends and v + 1's begins.
    for (std::size_t index = 0; index < faces.size(); ++index) {
      for (int corner = 0; corner < 3; ++corner)
        faces_[end_[faces[index][corner]]++] = static_cast<std::uint32_t>(index);
    }
  }

  // In ascending order.
  [[nodiscard]] std::span<const std::uint32_t> operator[](std::uint32_t vertex) const {
    const std::size_t begin = vertex == 0 ? 0 : end_[vertex - 1];
    return std::span(faces_).subspan(begin, end_[vertex] - begin);
  }

 private:
  std::vector<std::size_t> end_;
  std::vector<std::uint32_t> faces_;
};

}  // namespace lumatlas
