// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/contradicted_faces.h"

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "mesh/visibility/visibility.h"

namespace lumatlas {
namespace {

constexpr double kMostlyBehind = 0.5;       // share of a face's pixels that measure behind it
constexpr double kHardlyOn = 0.1;           // share of a face's pixels that measure the face
constexpr std::size_t kLeastCompared = 30;  // colours of a group
constexpr double kPlainlyBetter = 0.5;      // squared error of the measured surface's colours, of that of the face's

// Pixels that see a face, or that see faces around a vertex.
struct DepthVotes {
  float seen = 0, behind = 0, on = 0;
  DepthVotes& operator+=(const DepthVotes& other) {
    seen += other.seen;
    behind += other.behind;
    on += other.on;
    return *this;
  }
};

class Evidence {
 public:
  Evidence(const Mesh& mesh, std::span<const MeasuredView> views, const std::function<void()>& progress)
      : mesh_(mesh), views_(views), votes_(mesh.faces.size()), visible_(views.size()) {
    const std::unique_ptr<Visibility> visibility = make_ray_visibility(mesh);
    for (std::size_t view = 0; view < views.size(); ++view) {
      visibility->trace(views[view].measured.camera, visible_[view]);
      vote(static_cast<std::uint32_t>(view));
      progress();
    }
  }

  // Returns for each face whether the depths contradict it, or most of the faces around it and not itself.
  [[nodiscard]] std::vector<bool> contradicted_by_depth() const {
    std::vector<DepthVotes> at_vertex(mesh_.positions.size());
    for (std::size_t face = 0; face < votes_.size(); ++face) {
      for (int corner = 0; corner < 3; ++corner) at_vertex[mesh_.faces[face][corner]] += votes_[face];
    }
    std::vector<bool> result(votes_.size());
    for (std::size_t face = 0; face < votes_.size(); ++face) {
      DepthVotes around;
      for (int corner = 0; corner < 3; ++corner) around += at_vertex[mesh_.faces[face][corner]];
      result[face] = is_behind(around) && (votes_[face].seen == 0 || votes_[face].behind >= votes_[face].on);
    }
    return result;
  }

  // Pixels whose measured surface lies clearly behind the face that they see.
  [[nodiscard]] const std::vector<FacePixel>& pixels_behind() const { return behind_; }
  [[nodiscard]] const std::vector<DepthVotes>& votes() const { return votes_; }

  // Adds the squared errors of the colour of a pixel in the other views: at the face, and at the measured surface.
  void compare(const FacePixel& at, ColorErrors& errors) const {
    const MeasuredView& own = views_[at.view];
    const glm::dvec3 face = own.point_at(at.pixel, visible_[at.view].depth[at.pixel]);
    const glm::dvec3 behind = own.point_at(at.pixel, own.measured.depth[at.pixel]);
    for (std::size_t other = 0; other < views_.size(); ++other) {
      if (other == at.view) continue;
      const MeasuredView& view = views_[other];
      compare_colors(view, view.where_seen(face, visible_[other]), view.where_measured(behind), own.color[at.pixel],
                     errors);
    }
  }

 private:
  static bool is_behind(const DepthVotes& votes) {
    return static_cast<double>(votes.behind) > kMostlyBehind * static_cast<double>(votes.seen) &&
           static_cast<double>(votes.on) < kHardlyOn * static_cast<double>(votes.seen);
  }

  void vote(std::uint32_t view) {
    const VisibilityBuffer& visible = visible_[view];
    for (std::uint32_t pixel = 0; pixel < visible.face.size(); ++pixel) {
      const std::uint32_t face = visible.face[pixel];
      if (face == FaceId::none || views_[view].valid[pixel] == 0) continue;
      DepthVotes& votes = votes_[face];
      ++votes.seen;
      if (!views_[view].is_confirmed(pixel)) continue;
      const float difference = views_[view].measured.depth[pixel] - visible.depth[pixel];
      const float same = views_[view].same_depth(pixel);
      if (difference > same) {
        ++votes.behind;
        behind_.push_back({view, pixel, face});
      } else if (-difference <= same) {
        ++votes.on;
      }
    }
  }

  const Mesh& mesh_;
  std::span<const MeasuredView> views_;
  std::vector<DepthVotes> votes_;
  std::vector<VisibilityBuffer> visible_;
  std::vector<FacePixel> behind_;
};

bool is_contradicted(const PixelGroup& group, std::span<const MeasuredView> views, const Evidence& evidence) {
  if (!is_seen_around(group, views)) return false;
  ColorErrors errors;
  for (const FacePixel& at : group.pixels) evidence.compare(at, errors);
  return errors.compared >= kLeastCompared && errors.farther < kPlainlyBetter * errors.nearer;
}

// Adds faces beside those that go if most of their own measured pixels lie behind them. Such faces form the rim of a
// group: the votes around their vertices count faces that stay too.
void grow_to_rim(const Mesh& mesh, const std::vector<DepthVotes>& votes, std::vector<bool>& goes) {
  std::vector<bool> touched(mesh.positions.size(), false);
  bool grows = true;
  while (grows) {
    grows = false;
    for (std::size_t face = 0; face < goes.size(); ++face) {
      if (!goes[face]) continue;
      for (int corner = 0; corner < 3; ++corner) touched[mesh.faces[face][corner]] = true;
    }
    for (std::size_t face = 0; face < goes.size(); ++face) {
      const glm::uvec3& corners = mesh.faces[face];
      if (goes[face] || !(touched[corners.x] || touched[corners.y] || touched[corners.z])) continue;
      if (!(votes[face].behind > 2 * votes[face].on)) continue;
      goes[face] = true;
      grows = true;
    }
  }
}

}  // namespace

ContradictedFaces contradicted_faces(const Mesh& mesh, std::span<const MeasuredView> views,
                                     const std::function<void()>& progress) {
  const Evidence evidence(mesh, views, progress);
  const std::vector<bool> candidate = evidence.contradicted_by_depth();
  FaceGroups groups(mesh, candidate);
  std::map<std::uint32_t, PixelGroup> by_vertex;  // that represents the group
  for (const FacePixel& at : evidence.pixels_behind()) {
    if (candidate[at.face]) by_vertex[groups.of(at.face)].add(at, mesh);
  }
  ContradictedFaces result;
  std::set<std::uint32_t> contradicted;  // the vertex contradicts them too
  for (const auto& [vertex, group] : by_vertex) {
    if (is_contradicted(group, views, evidence)) contradicted.insert(vertex);
  }
  result.groups = contradicted.size();
  std::vector<bool> goes(candidate.size());
  for (std::size_t face = 0; face < goes.size(); ++face) {
    goes[face] = candidate[face] && contradicted.contains(groups.of(face));
  }
  grow_to_rim(mesh, evidence.votes(), goes);
  double seen = 0, gone = 0;
  for (std::size_t face = 0; face < candidate.size(); ++face) {
    const auto pixels = static_cast<double>(evidence.votes()[face].seen);
    seen += pixels;
    if (!goes[face]) continue;
    result.faces.push_back(static_cast<std::uint32_t>(face));
    gone += pixels;
  }
  result.pixels = seen > 0 ? gone / seen : 0;
  return result;
}

}  // namespace lumatlas
