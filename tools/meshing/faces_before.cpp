// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/faces_before.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <set>

#include "mesh/visibility/visibility.h"

namespace lumatlas {
namespace {

constexpr double kMostlyBefore = 0.5;      // share of the depths measured at a face that lie before the mesh
constexpr std::size_t kFewestColors = 30;  // of a group that are compared
constexpr double kPlainlyNearer = 0.5;     // squared error of the faces' colours, of that of the mesh behind them
constexpr double kOneSide = 0.707;         // cosine of 45 degrees

// Returns whether colours plainly fit the nearer of two points better.
bool fits(const ColorErrors& errors) {
  return errors.nearer < kPlainlyNearer * errors.farther;
}

// Evidence of the photographs that see a face, or faces around a vertex.
struct FaceEvidence {
  double before = 0;  // number of measured depths that are the face's, clearly before the mesh
  double others = 0;  // number of those that are the face's where the mesh is too, and of other depths
  ColorErrors errors;

  FaceEvidence& operator+=(const FaceEvidence& other) {
    before += other.before;
    others += other.others;
    errors += other.errors;
    return *this;
  }
  [[nodiscard]] bool is_before() const { return before > kMostlyBefore * (before + others) && fits(errors); }
};

class NearerEvidence {
 public:
  NearerEvidence(const Mesh& mesh, const Mesh& other, std::span<const MeasuredView> views,
                 const std::function<void()>& progress)
      : other_(other),
        views_(views),
        at_face_(other.faces.size()),
        mesh_seen_(views.size()),
        other_seen_(views.size()) {
    const std::unique_ptr<Visibility> of_mesh = make_ray_visibility(mesh), of_other = make_ray_visibility(other);
    for (std::uint32_t view = 0; view < views.size(); ++view) {
      of_mesh->trace(views[view].measured.camera, mesh_seen_[view]);
      of_other->trace(views[view].measured.camera, other_seen_[view]);
      count(view);
      progress();
    }
    for (const FacePixel& at : before_) compare(at);
  }

  // Returns for each face of the other mesh whether it and the faces around it stand before the mesh.
  [[nodiscard]] std::vector<bool> before() const {
    std::vector<FaceEvidence> at_vertex(other_.positions.size());
    for (std::size_t face = 0; face < at_face_.size(); ++face) {
      for (int corner = 0; corner < 3; ++corner) at_vertex[other_.faces[face][corner]] += at_face_[face];
    }
    std::vector<bool> result(at_face_.size());
    for (std::size_t face = 0; face < at_face_.size(); ++face) {
      FaceEvidence around;
      for (int corner = 0; corner < 3; ++corner) around += at_vertex[other_.faces[face][corner]];
      result[face] = around.is_before() && at_face_[face].before >= at_face_[face].others;
    }
    return result;
  }

  // Pixels whose measured surface is the face, clearly before the mesh.
  [[nodiscard]] const std::vector<FacePixel>& pixels_before() const { return before_; }
  [[nodiscard]] const ColorErrors& errors(std::uint32_t face) const { return at_face_[face].errors; }

 private:
  // Returns whether two views see a point of a face from the same side, from directions that differ by 45 degrees at
  // most: the two sides of an ear have different colours, and hardly any distance.
  [[nodiscard]] bool see_one_side(std::uint32_t face, const glm::dvec3& point, const MeasuredView& first,
                                  const MeasuredView& second) const {
    const glm::uvec3& corners = other_.faces[face];
    const glm::dvec3 a(other_.positions[corners.x]), b(other_.positions[corners.y]), c(other_.positions[corners.z]);
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const glm::dvec3 to_first = glm::normalize(first.measured.camera.center() - point);
    const glm::dvec3 to_second = glm::normalize(second.measured.camera.center() - point);
    return glm::dot(normal, to_first) * glm::dot(normal, to_second) > 0 && glm::dot(to_first, to_second) > kOneSide;
  }

  // Adds the squared errors of the colour of a pixel in the other views: at the face, and on the mesh behind it.
  void compare(const FacePixel& at) {
    const MeasuredView& own = views_[at.view];
    const glm::dvec3 face = own.point_at(at.pixel, other_seen_[at.view].depth[at.pixel]);
    const glm::dvec3 behind = own.point_at(at.pixel, mesh_seen_[at.view].depth[at.pixel]);
    for (std::size_t view = 0; view < views_.size(); ++view) {
      if (view == at.view || !see_one_side(at.face, face, own, views_[view])) continue;
      const MeasuredView& second = views_[view];
      if (!second.where_seen(behind, other_seen_[view])) continue;  // something stands before it there too
      compare_colors(second, second.where_seen(face, other_seen_[view]), second.where_seen(behind, mesh_seen_[view]),
                     own.color[at.pixel], at_face_[at.face].errors);
    }
  }

  void count(std::uint32_t view) {
    const VisibilityBuffer &mesh = mesh_seen_[view], &other = other_seen_[view];
    for (std::uint32_t pixel = 0; pixel < other.face.size(); ++pixel) {
      const std::uint32_t face = other.face[pixel];
      if (face == FaceId::none || mesh.face[pixel] == FaceId::none || !views_[view].is_confirmed(pixel)) continue;
      const float same = views_[view].same_depth(pixel);
      if (other.depth[pixel] - mesh.depth[pixel] > same) continue;  // behind the mesh
      const bool is_face = std::abs(views_[view].measured.depth[pixel] - other.depth[pixel]) <= same;
      const bool is_before = is_face && mesh.depth[pixel] - other.depth[pixel] > same;
      ++(is_before ? at_face_[face].before : at_face_[face].others);
      if (is_before) before_.push_back({view, pixel, face});
    }
  }

  const Mesh& other_;
  std::span<const MeasuredView> views_;
  std::vector<FaceEvidence> at_face_;
  std::vector<VisibilityBuffer> mesh_seen_, other_seen_;
  std::vector<FacePixel> before_;
};

}  // namespace

FacesBefore faces_before(const Mesh& mesh, const Mesh& other, std::span<const MeasuredView> views,
                         const std::function<void()>& progress) {
  const NearerEvidence evidence(mesh, other, views, progress);
  const std::vector<bool> candidate = evidence.before();
  FaceGroups groups(other, candidate);
  std::map<std::uint32_t, PixelGroup> by_vertex;  // that represents the group
  std::map<std::uint32_t, ColorErrors> errors;
  for (const FacePixel& at : evidence.pixels_before()) {
    if (candidate[at.face]) by_vertex[groups.of(at.face)].add(at, other);
  }
  for (std::uint32_t face = 0; face < candidate.size(); ++face) {
    if (candidate[face]) errors[groups.of(face)] += evidence.errors(face);
  }
  std::set<std::uint32_t> proven;  // the vertex of each group that stands before the mesh
  for (const auto& [vertex, group] : by_vertex) {
    const ColorErrors& of = errors[vertex];
    if (of.compared >= kFewestColors && fits(of) && is_seen_around(group, views)) proven.insert(vertex);
  }
  FacesBefore result{{}, proven.size()};
  for (std::uint32_t face = 0; face < candidate.size(); ++face) {
    if (candidate[face] && proven.contains(groups.of(face))) result.faces.push_back(face);
  }
  return result;
}

}  // namespace lumatlas
