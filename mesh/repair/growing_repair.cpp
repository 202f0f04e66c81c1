// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/growing_repair.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/finite.h"
#include "mesh/repair/collinear.h"
#include "mesh/repair/manifold_check.h"
#include "mesh/repair/manifold_repair.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();

template <typename Body>
void in_parallel(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 1 << 12), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

[[noreturn]] void refuse_growth(const std::string& complaint) {
  throw std::invalid_argument("growing repair: " + complaint);
}

// Throws unless the list is empty or names positions before, each once.
void check_previous_positions(const std::vector<VertexId>& previous, std::size_t positions, std::size_t before) {
  if (previous.empty()) return;
  if (previous.size() != positions) {
    refuse_growth("previous_position has " + std::to_string(previous.size()) + " entries, must be empty or have " +
                  std::to_string(positions));
  }
  std::vector<std::uint8_t> named(before, 0);
  for (const VertexId position : previous) {
    if (position == VertexId::none) continue;
    if (position >= before) {
      refuse_growth("previous_position names " + std::to_string(position) + " of " + std::to_string(before));
    }
    if (named[position] != 0) refuse_growth("previous_position names " + std::to_string(position) + " twice");
    named[position] = 1;
  }
}

void check_soup(const TriangleSoup& soup) {
  constexpr std::size_t kMost = 500'000'000;  // also the limit of a Mesh
  if (!soup.colors.empty()) refuse_growth("the soup has colours");
  if (std::max(soup.positions.size(), soup.faces.size()) > kMost) {
    refuse_growth("the soup has more than " + std::to_string(kMost) + " positions or faces");
  }
  for (std::size_t face = 0; face < soup.faces.size(); ++face) {
    const glm::uvec3& corners = soup.faces[face];
    if (std::max({corners.x, corners.y, corners.z}) < soup.positions.size()) continue;
    refuse_growth("face " + std::to_string(face) + " refers to no position");
  }
}

std::uint64_t hash_of_place(const glm::vec3& place) {
  std::uint64_t hash = 0;
  for (int axis = 0; axis < 3; ++axis) {
    hash ^= std::bit_cast<std::uint32_t>(place[axis] + 0.0f);  // -0 and 0 are one position
    hash *= 0x9e3779b97f4a7c15ull;
    hash ^= hash >> 32U;
  }
  return hash;
}

constexpr glm::uvec3 kNoCorners(kAbsent);

// Faces by the lowest of their corners, in their order; those with kNoCorners are left out.
class FacesByCorner {
 public:
  FacesByCorner(std::size_t corners, const std::vector<glm::uvec3>& faces) : end_(corners + 1, 0) {
    const auto lowest = [](const glm::uvec3& face) { return std::min({face.x, face.y, face.z}); };
    for (const glm::uvec3& face : faces) {
      if (face != kNoCorners) ++end_[lowest(face) + 1];
    }
    for (std::size_t corner = 0; corner < corners; ++corner) end_[corner + 1] += end_[corner];
    faces_.resize(end_.back());
    for (std::uint32_t face = 0; face < faces.size(); ++face) {
      if (faces[face] != kNoCorners) faces_[end_[lowest(faces[face])]++] = face;
    }
  }

  [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t corner) const {
    const std::uint32_t begin = corner == 0 ? 0 : end_[corner - 1];
    return std::span(faces_).subspan(begin, end_[corner] - begin);
  }

 private:
  std::vector<std::uint32_t> end_, faces_;
};

// The face turned so that its lowest corner comes first: its other corners, and its number.
struct TurnedFace {
  std::uint32_t second, third, face;
  [[nodiscard]] auto corners() const { return std::tie(second, third); }
  bool operator<(const TurnedFace& other) const {
    return std::tie(second, third, face) < std::tie(other.second, other.third, other.face);
  }
};

// Sorted, so that faces with the same corners keep their order.
std::vector<TurnedFace> turned_faces(std::span<const std::uint32_t> of_corner, const std::vector<glm::uvec3>& faces) {
  std::vector<TurnedFace> turned;
  for (const std::uint32_t face : of_corner) {
    const glm::uvec3& f = faces[face];
    if (f.x <= f.y && f.x <= f.z) {
      turned.push_back({f.y, f.z, face});
    } else if (f.y <= f.z) {
      turned.push_back({f.z, f.x, face});
    } else {
      turned.push_back({f.x, f.y, face});
    }
  }
  std::sort(turned.begin(), turned.end());
  return turned;
}

// Returns for each face the one before that it was, by the corners that it had then.
std::vector<FaceId> faces_that_were(const std::vector<glm::uvec3>& before, std::size_t positions_before,
                                    const std::vector<glm::uvec3>& corners_then) {
  std::vector<FaceId> previous(corners_then.size(), FaceId::none);
  const FacesByCorner old_faces(positions_before, before), new_faces(positions_before, corners_then);
  in_parallel(positions_before, [&](std::size_t corner) {
    if (new_faces[corner].empty() || old_faces[corner].empty()) return;
    const std::vector<TurnedFace> now = turned_faces(new_faces[corner], corners_then);
    const std::vector<TurnedFace> then = turned_faces(old_faces[corner], before);
    for (auto face = now.begin(), old_face = then.begin(); face != now.end() && old_face != then.end();) {
      if (face->corners() == old_face->corners()) {
        previous[(face++)->face] = FaceId((old_face++)->face);
      } else if (face->corners() < old_face->corners()) {
        ++face;
      } else {
        ++old_face;
      }
    }
  });
  return previous;
}

// The positions as floats, and for each the point that it is: positions at one place are one point. kAbsent: the
// position is not finite.
struct Points {
  std::vector<glm::vec3> places;
  std::vector<std::uint32_t> of_position;
  std::vector<std::uint32_t> place_of;  // by point, one of its positions
};

struct HashedPosition {
  std::uint64_t hash;
  std::uint32_t position;
  bool is_new;
  bool operator<(const HashedPosition& other) const {
    return std::tie(hash, is_new, position) < std::tie(other.hash, other.is_new, other.position);
  }
};

// Returns for each new position the one at the same place that it is joined to, which is not new or comes first;
// kAbsent: none.
std::vector<std::uint32_t> joined_to(const std::vector<glm::vec3>& places, const std::vector<std::uint8_t>& is_new) {
  const auto count = static_cast<std::size_t>(std::count(is_new.begin(), is_new.end(), 1));
  std::vector<std::uint32_t> joined(places.size(), kAbsent);
  if (count == 0) return joined;
  // A bit for what a new position may hash to, of 64 for each of these.
  const unsigned shift = 64U - std::min(34U, static_cast<unsigned>(std::bit_width(count)) + 6U);
  std::vector<std::uint64_t> bits((std::uint64_t{1} << (64U - shift)) / 64);
  std::vector<std::uint64_t> hashes(places.size());
  in_parallel(places.size(), [&](std::size_t i) { hashes[i] = hash_of_place(places[i]); });
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (is_new[i] != 0) bits[hashes[i] >> shift >> 6U] |= std::uint64_t{1} << (hashes[i] >> shift & 63U);
  }
  std::vector<HashedPosition> suspects;
  for (std::uint32_t i = 0; i < places.size(); ++i) {
    if ((bits[hashes[i] >> shift >> 6U] >> (hashes[i] >> shift & 63U) & 1U) == 0 || !is_finite(places[i])) continue;
    suspects.push_back({hashes[i], i, is_new[i] != 0});
  }
  tbb::parallel_sort(suspects);
  for (auto first = suspects.begin(); first != suspects.end();) {
    const auto end = std::find_if(first, suspects.end(), [&](const auto& other) { return other.hash != first->hash; });
    for (auto later = first; later != end; ++later) {
      if (!later->is_new) continue;
      const auto same = std::find_if(
          first, later, [&](const auto& other) { return places[other.position] == places[later->position]; });
      if (same != later) joined[later->position] = same->position;
    }
    first = end;
  }
  return joined;
}

}  // namespace

// The soup before, and what became of it.
struct GrowingRepair::State {
  std::vector<glm::uvec3> soup_faces;
  std::vector<std::uint32_t> point_of_position;
  std::size_t points = 0;
  std::vector<glm::uvec3> mesh_corners;  // by face of the soup, of what it became
  std::vector<FaceId> mesh_face;         // by face of the soup; none: it was dropped
  std::size_t mesh_vertices = 0;
  bool has_opposed_faces = false;
  std::size_t faces_repaired = 0;
};

namespace {

// One step from a version to the next.
template <typename State>
class Step {
 public:
  Step(const State& before, const GrownSoup& grown) : before_(before), grown_(grown), soup_(grown.soup) {}

  GrownMesh run(State& after) {
    find_faces_before();
    find_points();
    find_dirty_points();
    if (before_.has_opposed_faces || !keeps_order() || !repair_near(false)) {
      std::fill(dirty_.begin(), dirty_.end(), std::uint8_t{1});
      (void)repair_near(true);
    }
    GrownMesh result = compose(after);
    after.faces_repaired = faces_.size() + dropped_;
    return result;
  }

 private:
  [[nodiscard]] VertexId position_before(std::size_t position) const {
    return grown_.previous_position.empty() ? VertexId::none : grown_.previous_position[position];
  }
  [[nodiscard]] FaceId face_before(std::size_t face) const {
    return faces_before_.empty() ? FaceId::none : faces_before_[face];
  }
  // Returns whether the faces that stay come in the order that they had. Of faces between the same three points the
  // first one is kept, which may be another one after a change of the order.
  [[nodiscard]] bool keeps_order() const {
    std::uint32_t last = 0;
    for (const FaceId before : faces_before_) {
      if (before == FaceId::none) continue;
      if (before < last) return false;
      last = before;
    }
    return true;
  }
  [[nodiscard]] glm::uvec3 points_of(std::size_t face) const {
    const glm::uvec3& corners = soup_.faces[face];
    return {points_.of_position[corners.x], points_.of_position[corners.y], points_.of_position[corners.z]};
  }

  void find_faces_before() {
    if (grown_.previous_position.empty()) return;
    std::vector<glm::uvec3> corners_then(soup_.faces.size(), kNoCorners);
    in_parallel(soup_.faces.size(), [&](std::size_t face) {
      glm::uvec3 then;
      for (int corner = 0; corner < 3; ++corner) then[corner] = position_before(soup_.faces[face][corner]);
      if (std::max({then.x, then.y, then.z}) != kAbsent) corners_then[face] = then;
    });
    faces_before_ = faces_that_were(before_.soup_faces, before_.point_of_position.size(), corners_then);
  }

  void find_points() {
    const std::size_t count = soup_.positions.size();
    points_.places.resize(count);
    std::vector<std::uint8_t> is_new(count);
    in_parallel(count, [&](std::size_t i) {
      points_.places[i] = glm::vec3(soup_.positions[i]);
      is_new[i] = position_before(i) == VertexId::none ? 1 : 0;
    });
    points_.of_position.assign(count, kAbsent);
    point_now_.assign(before_.points, kAbsent);
    const auto add_point = [&](std::size_t position) {
      points_.place_of.push_back(static_cast<std::uint32_t>(position));
      return static_cast<std::uint32_t>(points_.place_of.size() - 1);
    };
    for (std::size_t i = 0; i < count; ++i) {
      if (is_new[i] != 0) continue;
      const std::uint32_t before = before_.point_of_position[position_before(i)];
      if (before == kAbsent) continue;
      if (point_now_[before] == kAbsent) point_now_[before] = add_point(i);
      points_.of_position[i] = point_now_[before];
    }
    const std::vector<std::uint32_t> joined = joined_to(points_.places, is_new);
    for (std::size_t i = 0; i < count; ++i) {
      if (is_new[i] == 0 || !is_finite(points_.places[i])) continue;
      points_.of_position[i] = joined[i] == kAbsent ? add_point(i) : points_.of_position[joined[i]];
    }
  }

  // Points at which a face came or went.
  void find_dirty_points() {
    dirty_.assign(points_.place_of.size(), 0);
    std::vector<std::uint8_t> stays(before_.soup_faces.size(), 0);
    for (std::size_t face = 0; face < soup_.faces.size(); ++face) {
      if (face_before(face) != FaceId::none) {
        stays[face_before(face)] = 1;
        continue;
      }
      const glm::uvec3 points = points_of(face);
      for (int corner = 0; corner < 3; ++corner) {
        if (points[corner] != kAbsent) dirty_[points[corner]] = 1;
      }
    }
    for (std::size_t face = 0; face < stays.size(); ++face) {
      if (stays[face] != 0) continue;
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t point = before_.point_of_position[before_.soup_faces[face][corner]];
        if (point != kAbsent && point_now_[point] != kAbsent) dirty_[point_now_[point]] = 1;
      }
    }
  }

  // Lists the faces around dirty points, and numbers their points.
  void find_region() {
    std::vector<std::uint32_t> all;
    region_.assign(soup_.faces.size(), 0);
    std::vector<std::uint8_t> degenerate(soup_.faces.size(), 0);
    in_parallel(soup_.faces.size(), [&](std::size_t face) {
      const glm::uvec3 p = points_of(face);
      if (std::max({p.x, p.y, p.z}) == kAbsent) return;
      if (dirty_[p.x] == 0 && dirty_[p.y] == 0 && dirty_[p.z] == 0) return;
      region_[face] = 1;
      const auto at = [&](std::uint32_t point) { return points_.places[points_.place_of[point]]; };
      degenerate[face] = p.x == p.y || p.y == p.z || p.z == p.x || are_collinear(at(p.x), at(p.y), at(p.z)) ? 1 : 0;
    });
    std::vector<std::uint32_t> number(points_.place_of.size(), kAbsent);
    local_points_.clear();
    triangles_.clear();
    faces_.clear();
    dropped_ = 0;
    for (std::uint32_t face = 0; face < region_.size(); ++face) {
      if (region_[face] == 0) continue;
      if (degenerate[face] != 0) {
        ++dropped_;
        continue;
      }
      const glm::uvec3 points = points_of(face);
      std::array<std::uint32_t, 3> triangle{};
      for (int corner = 0; corner < 3; ++corner) {
        std::uint32_t& local = number[points[corner]];
        if (local == kAbsent) {
          local = static_cast<std::uint32_t>(local_points_.size());
          local_points_.push_back(points[corner]);
        }
        triangle.at(static_cast<std::size_t>(corner)) = local;
      }
      triangles_.push_back(triangle);
      faces_.push_back(face);
    }
  }

  // Repairs the faces around dirty points. Returns false, unless these are all, if faces turn against each other.
  bool repair_near(bool all) {
    find_region();
    {
      const VertexFaces around(local_points_.size(), triangles_);
      std::vector<std::uint32_t> suspects = vertices_without_one_fan(local_points_.size(), triangles_, around);
      drop(duplicate_faces(triangles_, around, suspects));
    }
    const VertexFaces around(local_points_.size(), triangles_);
    std::vector<std::uint32_t> suspects = vertices_without_one_fan(local_points_.size(), triangles_, around);
    has_opposed_faces_ = lumatlas::has_opposed_faces(triangles_, around, suspects);
    if (has_opposed_faces_ && !all) return false;
    // A point at the rim of the region has not all of its faces there.
    std::erase_if(suspects, [&](std::uint32_t local) { return dirty_[local_points_[local]] == 0; });
    copies_ = orient_and_split(local_points_.size(), triangles_, around, suspects).copies;
    return true;
  }

  // Drops these of the region's faces, ascending.
  void drop(const std::vector<std::uint32_t>& duplicates) {
    std::size_t kept = 0;
    auto next = duplicates.begin();
    for (std::uint32_t i = 0; i < faces_.size(); ++i) {
      if (next != duplicates.end() && *next == i) {
        ++next;
        continue;
      }
      triangles_[kept] = triangles_[i];
      faces_[kept++] = faces_[i];
    }
    dropped_ += faces_.size() - kept;
    triangles_.resize(kept);
    faces_.resize(kept);
  }

  // Returns the vertex of the mesh before at a corner of a face that stays.
  [[nodiscard]] std::uint32_t vertex_before(std::size_t face, int corner) const {
    const FaceId before = face_before(face);
    const VertexId position = position_before(soup_.faces[face][corner]);
    const glm::uvec3& corners = before_.soup_faces[before];
    int then = 0;
    while (corners[then] != position) ++then;
    return before_.mesh_corners[before][then];
  }

  GrownMesh compose(State& after) const {
    GrownMesh result;
    Mesh& mesh = result.mesh;
    std::vector<std::uint32_t> of_vertex_before(before_.mesh_vertices, kAbsent);
    std::vector<std::uint32_t> of_local(local_points_.size() + copies_.size(), kAbsent);
    const auto number = [&](std::uint32_t& known, std::uint32_t position) {
      if (known == kAbsent) {
        known = static_cast<std::uint32_t>(mesh.positions.size());
        mesh.positions.push_back(points_.places[position]);
      }
      return known;
    };
    after.mesh_face.assign(soup_.faces.size(), FaceId::none);
    after.mesh_corners.assign(soup_.faces.size(), glm::uvec3(kAbsent));
    mesh.positions.reserve(points_.place_of.size());
    mesh.faces.reserve(soup_.faces.size());
    result.previous_face.reserve(soup_.faces.size());
    std::size_t repaired = 0;
    for (std::uint32_t face = 0; face < soup_.faces.size(); ++face) {
      const FaceId before = face_before(face);
      const FaceId mesh_face_before = before == FaceId::none ? FaceId::none : before_.mesh_face[before];
      glm::uvec3 corners;
      if (region_[face] != 0) {
        if (repaired == faces_.size() || faces_[repaired] != face) continue;
        for (int corner = 0; corner < 3; ++corner) {
          const std::uint32_t local = triangles_[repaired][static_cast<std::size_t>(corner)];
          const std::uint32_t point =
              local_points_[local < local_points_.size() ? local : copies_[local - local_points_.size()]];
          std::uint32_t& known = dirty_[point] != 0 ? of_local[local] : of_vertex_before[vertex_before(face, corner)];
          corners[corner] = number(known, points_.place_of[point]);
        }
        ++repaired;
      } else {
        if (mesh_face_before == FaceId::none) continue;
        for (int corner = 0; corner < 3; ++corner) {
          corners[corner] = number(of_vertex_before[vertex_before(face, corner)], soup_.faces[face][corner]);
        }
      }
      after.mesh_face[face] = FaceId(static_cast<std::uint32_t>(mesh.faces.size()));
      after.mesh_corners[face] = corners;
      mesh.faces.push_back(corners);
      result.previous_face.push_back(mesh_face_before);
    }
    after.soup_faces = soup_.faces;
    after.point_of_position = points_.of_position;
    after.points = points_.place_of.size();
    after.mesh_vertices = mesh.positions.size();
    after.has_opposed_faces = has_opposed_faces_;
    return result;
  }

  const State& before_;
  const GrownSoup& grown_;
  const TriangleSoup& soup_;
  std::vector<FaceId> faces_before_;  // empty: none was there
  Points points_;
  std::vector<std::uint32_t> point_now_;  // by point before; kAbsent: it has gone
  std::vector<std::uint8_t> dirty_;       // by point
  // The region, which is all faces around dirty points.
  std::vector<std::uint8_t> region_;         // by face of the soup
  std::vector<std::uint32_t> local_points_;  // that its faces have
  TriangleList triangles_;                   // of numbers of these, and of their copies
  std::vector<std::uint32_t> faces_;         // of the soup, which the triangles are
  std::size_t dropped_ = 0;                  // faces of the region
  std::vector<std::uint32_t> copies_;
  bool has_opposed_faces_ = false;
};

}  // namespace

GrowingRepair::GrowingRepair() : state_(std::make_unique<State>()) {}

GrowingRepair::~GrowingRepair() = default;

GrownMesh GrowingRepair::next(const GrownSoup& grown) {
  check_soup(grown.soup);
  check_previous_positions(grown.previous_position, grown.soup.positions.size(), state_->point_of_position.size());
  auto after = std::make_unique<State>();
  GrownMesh result = Step<State>(*state_, grown).run(*after);
  if (result.mesh.faces.empty()) throw InputError("the mesh has no usable face");
  state_ = std::move(after);
  return result;
}

std::size_t GrowingRepair::faces_repaired() const {
  return state_->faces_repaired;
}

}  // namespace lumatlas
