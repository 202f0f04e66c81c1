// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/meshing/contradicted_faces.h"

#include <algorithm>
#include <bit>
#include <boost/pending/disjoint_sets.hpp>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "mesh/visibility/visibility.h"

namespace lumatlas {
namespace {

constexpr int kLeastAgreeing = 2;            // photographs that confirm a depth
constexpr float kDeviations = 4;             // deviations of a measured depth, and
constexpr float kLeastDistance = 0.05F;      // share of the depth, by which a measured point lies off a face
constexpr double kMostlyBehind = 0.5;        // share of a face's pixels that measure behind it
constexpr double kHardlyOn = 0.1;            // share of a face's pixels that measure the face
constexpr std::size_t kLeastViewPixels = 8;  // least size of a group in a view that counts
constexpr std::size_t kLeastViews = 3;       // from different directions
constexpr double kOtherDirection = 0.9976;   // cosine of 4 degrees
constexpr double kLeastParallaxPx = 2;       // between a face and what is behind it, to tell their colours apart
constexpr std::size_t kLeastCompared = 30;   // colours of a group
constexpr double kPlainlyBetter = 0.5;       // squared error of the measured surface's colours, of that of the face's

// A pixel whose measured surface lies clearly behind the face that it sees.
struct PixelBehind {
  std::uint32_t view, pixel, face;
};

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

glm::dvec2 middle_of(std::size_t pixel, std::uint32_t width) {
  const std::size_t x = pixel % width, y = pixel / width;
  return {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5};
}

// Returns where a point is in an image; none: behind the camera or outside.
std::optional<glm::dvec2> image_of(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 cam = camera.cam_from_world(point);
  if (!(cam.z > 0)) return std::nullopt;
  const glm::dvec2 at = camera.image_from_cam(cam);
  if (!(at.x >= 1 && at.y >= 1 && at.x < camera.width - 1.0 && at.y < camera.height - 1.0)) return std::nullopt;
  return at;
}

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

  [[nodiscard]] const std::vector<PixelBehind>& pixels_behind() const { return behind_; }
  [[nodiscard]] const std::vector<DepthVotes>& votes() const { return votes_; }

  // Adds the squared errors of the colour of a pixel in the other views: at the face, and at the measured surface.
  struct ColorErrors {
    double face = 0, behind = 0;
    std::size_t compared = 0;
  };
  void compare(const PixelBehind& at, ColorErrors& errors) const {
    const MeasuredView& own = views_[at.view];
    const Camera& camera = own.measured.camera;
    const glm::dvec3 ray = camera.ray(middle_of(at.pixel, camera.width));
    const glm::dvec3 face = camera.center() + double{visible_[at.view].depth[at.pixel]} * ray;
    const glm::dvec3 behind = camera.center() + double{own.measured.depth[at.pixel]} * ray;
    for (std::size_t other = 0; other < views_.size(); ++other) {
      if (other == at.view) continue;
      const std::optional<glm::dvec2> on_face = seen_on_mesh(other, face), on_behind = seen_behind(other, behind);
      if (!on_face || !on_behind || glm::distance(*on_face, *on_behind) < kLeastParallaxPx) continue;
      errors.face += squared_difference(color_at(other, *on_face), own.color[at.pixel]);
      errors.behind += squared_difference(color_at(other, *on_behind), own.color[at.pixel]);
      ++errors.compared;
    }
  }

  [[nodiscard]] glm::dvec3 center(std::size_t view) const { return views_[view].measured.camera.center(); }
  [[nodiscard]] std::size_t views() const { return views_.size(); }

 private:
  static bool is_behind(const DepthVotes& votes) {
    return static_cast<double>(votes.behind) > kMostlyBehind * static_cast<double>(votes.seen) &&
           static_cast<double>(votes.on) < kHardlyOn * static_cast<double>(votes.seen);
  }

  // The largest difference of depths that count as the same.
  static float same_depth(float depth, float deviation) {
    return std::max(kDeviations * deviation, kLeastDistance * depth);
  }

  void vote(std::uint32_t view) {
    const VisibilityBuffer& visible = visible_[view];
    const StereoDepth& measured = views_[view].measured;
    for (std::uint32_t pixel = 0; pixel < visible.face.size(); ++pixel) {
      const std::uint32_t face = visible.face[pixel];
      if (face == FaceId::none || views_[view].valid[pixel] == 0) continue;
      DepthVotes& votes = votes_[face];
      ++votes.seen;
      const float depth = measured.depth[pixel];
      if (!(depth > 0) || std::popcount(measured.agreeing[pixel]) < kLeastAgreeing) continue;
      const float same = same_depth(depth, measured.deviation[pixel]);
      if (depth - visible.depth[pixel] > same) {
        ++votes.behind;
        behind_.push_back({view, pixel, face});
      } else if (visible.depth[pixel] - depth <= same) {
        ++votes.on;
      }
    }
  }

  // Returns where a view sees a point of the mesh; none: something else is before it.
  [[nodiscard]] std::optional<glm::dvec2> seen_on_mesh(std::size_t view, const glm::dvec3& point) const {
    const Camera& camera = views_[view].measured.camera;
    const std::optional<glm::dvec2> at = image_of(camera, point);
    if (!at) return std::nullopt;
    const std::size_t pixel = pixel_at(*at, camera);
    const double depth = camera.cam_from_world(point).z;
    const bool same = std::abs(double{visible_[view].depth[pixel]} - depth) < double{kLeastDistance} * depth;
    return visible_[view].face[pixel] != FaceId::none && same && views_[view].valid[pixel] != 0 ? at : std::nullopt;
  }

  // Returns where a view measures a point; none: it measures another depth there.
  [[nodiscard]] std::optional<glm::dvec2> seen_behind(std::size_t view, const glm::dvec3& point) const {
    const StereoDepth& measured = views_[view].measured;
    const std::optional<glm::dvec2> at = image_of(measured.camera, point);
    if (!at) return std::nullopt;
    const std::size_t pixel = pixel_at(*at, measured.camera);
    const auto depth = static_cast<float>(measured.camera.cam_from_world(point).z);
    const bool same = measured.depth[pixel] > 0 &&
                      std::abs(measured.depth[pixel] - depth) <= same_depth(depth, measured.deviation[pixel]);
    return same && views_[view].valid[pixel] != 0 ? at : std::nullopt;
  }

  static std::size_t pixel_at(const glm::dvec2& at, const Camera& camera) {
    return static_cast<std::size_t>(at.y) * camera.width + static_cast<std::size_t>(at.x);
  }

  // Returns the colour at an image position, bilinear; at least a pixel from the border.
  [[nodiscard]] glm::vec3 color_at(std::size_t view, const glm::dvec2& at) const {
    const std::vector<glm::vec3>& color = views_[view].color;
    const std::size_t width = views_[view].measured.camera.width;
    const glm::dvec2 corner = glm::floor(at - 0.5);
    const glm::vec2 share(at - 0.5 - corner);
    const std::size_t pixel = static_cast<std::size_t>(corner.y) * width + static_cast<std::size_t>(corner.x);
    return glm::mix(glm::mix(color[pixel], color[pixel + 1], share.x),
                    glm::mix(color[pixel + width], color[pixel + width + 1], share.x), share.y);
  }

  static double squared_difference(const glm::vec3& a, const glm::vec3& b) {
    const glm::dvec3 difference(a - b);
    return glm::dot(difference, difference);
  }

  const Mesh& mesh_;
  std::span<const MeasuredView> views_;
  std::vector<DepthVotes> votes_;
  std::vector<VisibilityBuffer> visible_;
  std::vector<PixelBehind> behind_;
};

// Connected groups of some faces of a mesh, by a vertex that represents each.
class FaceGroups {
 public:
  FaceGroups(const Mesh& mesh, const std::vector<bool>& wanted) : mesh_(mesh), sets_(mesh.positions.size()) {
    for (std::size_t face = 0; face < wanted.size(); ++face) {
      if (!wanted[face]) continue;
      sets_.union_set(mesh.faces[face].x, mesh.faces[face].y);
      sets_.union_set(mesh.faces[face].x, mesh.faces[face].z);
    }
  }
  [[nodiscard]] std::uint32_t of(std::size_t face) {
    return static_cast<std::uint32_t>(sets_.find_set(mesh_.faces[face].x));
  }

 private:
  const Mesh& mesh_;
  boost::disjoint_sets_with_storage<> sets_;
};

struct Group {
  glm::dvec3 sum{0};  // sum of the centres of its pixels' faces
  std::vector<PixelBehind> pixels;

  [[nodiscard]] glm::dvec3 middle() const { return sum / static_cast<double>(pixels.size()); }
};

// Number of views with enough of the group's pixels, each from another direction than the ones before.
std::size_t directions_to(const Group& group, const Evidence& evidence) {
  std::vector<std::size_t> pixels(evidence.views(), 0);
  for (const PixelBehind& at : group.pixels) ++pixels[at.view];
  std::vector<glm::dvec3> directions;
  for (std::size_t view = 0; view < pixels.size(); ++view) {
    if (pixels[view] < kLeastViewPixels) continue;
    const glm::dvec3 direction = glm::normalize(evidence.center(view) - group.middle());
    const bool is_new = std::all_of(directions.begin(), directions.end(), [&](const glm::dvec3& other) {
      return glm::dot(direction, other) < kOtherDirection;
    });
    if (is_new) directions.push_back(direction);
  }
  return directions.size();
}

bool is_contradicted(const Group& group, const Evidence& evidence) {
  if (directions_to(group, evidence) < kLeastViews) return false;
  Evidence::ColorErrors errors;
  for (const PixelBehind& at : group.pixels) evidence.compare(at, errors);
  return errors.compared >= kLeastCompared && errors.behind < kPlainlyBetter * errors.face;
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
  std::map<std::uint32_t, Group> by_vertex;  // that represents the group
  for (const PixelBehind& at : evidence.pixels_behind()) {
    if (!candidate[at.face]) continue;
    Group& group = by_vertex[groups.of(at.face)];
    group.sum += glm::dvec3(mesh.positions[mesh.faces[at.face].x]);
    group.pixels.push_back(at);
  }
  ContradictedFaces result;
  std::set<std::uint32_t> contradicted;  // the vertex contradicts them too
  for (const auto& [vertex, group] : by_vertex) {
    if (is_contradicted(group, evidence)) contradicted.insert(vertex);
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
