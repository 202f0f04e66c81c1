// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/mesh_completion.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "mesh/repair/repair.h"
#include "mesh/used_vertices.h"
#include "mesh/visibility/visibility.h"
#include "tools/meshing/cut/small_pieces.h"

namespace lumatlas {
namespace {

constexpr std::size_t kFewestAdded = 100;  // fewest faces of a piece that is not taken for noise

// Number of pixels of all photographs that see a face of the other mesh.
struct Votes {
  std::uint32_t lacking = 0;  // views that see nothing of the given mesh there
  std::uint32_t present = 0;  // views that see something of it, before or behind
};

class Completion {
 public:
  Completion(const Mesh& given, const Mesh& other)
      : given_(make_ray_visibility(given)), other_(make_ray_visibility(other)), votes_(other.faces.size()) {}

  void look(const Camera& full_size) {
    const Camera view = full_size.shrunk_to(kCompletionPx);
    given_->trace(view, given_buffer_);
    other_->trace(view, other_buffer_);
    for (std::size_t pixel = 0; pixel < given_buffer_.face.size(); ++pixel) {
      const bool is_given = given_buffer_.face[pixel] != FaceId::none;
      ++pixels_;
      covered_ += is_given ? 1 : 0;
      const std::uint32_t face = other_buffer_.face[pixel];
      if (face == FaceId::none) continue;
      ++(is_given ? votes_[face].present : votes_[face].lacking);
    }
  }

  [[nodiscard]] bool is_lacking(std::size_t face) const { return votes_[face].lacking > votes_[face].present; }
  [[nodiscard]] double covered() const {
    return pixels_ == 0 ? 0 : static_cast<double>(covered_) / static_cast<double>(pixels_);
  }

 private:
  std::unique_ptr<Visibility> given_, other_;
  VisibilityBuffer given_buffer_, other_buffer_;
  std::vector<Votes> votes_;
  std::size_t pixels_ = 0, covered_ = 0;
};

double covered_share(const Mesh& mesh, std::span<const Camera> views) {
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(mesh);
  VisibilityBuffer buffer;
  std::size_t covered = 0, pixels = 0;
  for (const Camera& view : views) {
    visibility->trace(view.shrunk_to(kCompletionPx), buffer);
    covered +=
        buffer.face.size() - static_cast<std::size_t>(std::count(buffer.face.begin(), buffer.face.end(), FaceId::none));
    pixels += buffer.face.size();
  }
  return pixels == 0 ? 0 : static_cast<double>(covered) / static_cast<double>(pixels);
}

glm::u8vec3 mean_color(const std::vector<glm::u8vec3>& colors) {
  glm::dvec3 sum(0);
  for (const glm::u8vec3& color : colors) sum += glm::dvec3(color);
  return glm::u8vec3(sum / static_cast<double>(std::max<std::size_t>(1, colors.size())) + 0.5);
}

}  // namespace

void append_faces(const TriangleSoup& part, TriangleSoup& surface) {
  const bool has_colors = !surface.colors.empty();
  const glm::u8vec3 color = mean_color(surface.colors);
  UsedVertices used(part.positions.size(), surface.positions.size());
  for (glm::uvec3 face : part.faces) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t vertex = face[i];
      face[i] = used.number_of(vertex, [&] {
        surface.positions.push_back(part.positions[vertex]);
        if (has_colors) surface.colors.push_back(color);
      });
    }
    surface.faces.push_back(face);
  }
}

CompletedMesh completed(const TriangleSoup& given, const TriangleSoup& other, std::span<const Camera> views,
                        const glm::dvec3& offset, const std::function<void()>& progress) {
  const Mesh other_mesh = repair(other, offset).mesh;
  Completion completion(repair(given, offset).mesh, other_mesh);
  for (const Camera& view : views) {
    completion.look(view);
    progress();
  }
  TriangleSoup added;
  for (const glm::vec3& position : other_mesh.positions) added.positions.push_back(glm::dvec3(position) + offset);
  for (std::size_t face = 0; face < other_mesh.faces.size(); ++face) {
    if (completion.is_lacking(face)) added.faces.push_back(other_mesh.faces[face]);
  }
  remove_small_pieces(added, kFewestAdded);
  CompletedMesh result{given, added.faces.size(), completion.covered(), completion.covered()};
  if (added.faces.empty()) return result;
  append_faces(added, result.surface);
  result.covered = covered_share(repair(result.surface, offset).mesh, views);
  return result;
}

}  // namespace lumatlas
