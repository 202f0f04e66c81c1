// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/growing/growing_repair.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>
#include <stdexcept>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/repair/collinear.h"
#include "mesh/repair/growing/joined_positions.h"
#include "mesh/repair/growing/kept_faces.h"
#include "mesh/repair/manifold_check.h"
#include "mesh/repair/manifold_repair.h"
#include "mesh/repair/orientation.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kAbsent = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kChunk = 1 << 14;  // faces or positions that a thread takes at once

template <typename Body>
void in_parallel(std::size_t count, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kChunk), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) body(i);
  });
}

[[noreturn]] void refuse_growth(const std::string& complaint) {
  throw std::invalid_argument("growing repair: " + complaint);
}

// Returns for each position before which one it is now; none: it is gone. Throws unless the list is empty or names
// positions before, each once.
std::vector<VertexId> positions_now(const std::vector<VertexId>& previous, std::size_t positions, std::size_t before) {
  std::vector<VertexId> now(before, VertexId::none);
  if (previous.empty()) return now;
  if (previous.size() != positions) {
    refuse_growth("previous_position has " + std::to_string(previous.size()) + " entries, must be empty or have " +
                  std::to_string(positions));
  }
  for (VertexId position{0}; position < positions; ++position) {
    const VertexId then = previous[position];
    if (then == VertexId::none) continue;
    if (then >= before) {
      refuse_growth("previous_position names " + std::to_string(then) + " of " + std::to_string(before));
    }
    if (now[then] != VertexId::none) refuse_growth("previous_position names " + std::to_string(then) + " twice");
    now[then] = position;
  }
  return now;
}

// Returns the first face that refers to no position; the number of faces if there is none.
std::size_t first_face_beyond(const TriangleSoup& soup) {
  const auto search = [&](const tbb::blocked_range<std::size_t>& range, std::size_t found) {
    for (std::size_t face = range.begin(); face < range.end() && face < found; ++face) {
      const glm::uvec3& corners = soup.faces[face];
      if (std::max({corners.x, corners.y, corners.z}) >= soup.positions.size()) return face;
    }
    return found;
  };
  return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, soup.faces.size(), kChunk), soup.faces.size(), search,
                              [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

void check_soup(const TriangleSoup& soup) {
  constexpr std::size_t kMost = 500'000'000;  // also the limit of a Mesh
  if (!soup.colors.empty()) refuse_growth("the soup has colours");
  if (std::max(soup.positions.size(), soup.faces.size()) > kMost) {
    refuse_growth("the soup has more than " + std::to_string(kMost) + " positions or faces");
  }
  const std::size_t beyond = first_face_beyond(soup);
  if (beyond < soup.faces.size()) refuse_growth("face " + std::to_string(beyond) + " refers to no position");
}

}  // namespace

// The soup before, and what became of it.
struct GrowingRepair::State {
  std::vector<glm::uvec3> soup_faces;
  PointOfPosition point;
  std::vector<FaceId> mesh_face;  // by face of the soup; none: it was dropped
  std::vector<glm::uvec3> mesh_faces;
  // By face of the mesh, a bit for each corner, the first one lowest: no corner before it has its vertex.
  std::vector<std::uint8_t> first_uses;
  std::size_t mesh_vertices = 0;
  std::vector<VertexId> suspects;     // points that vertices_without_one_fan() names before faces are turned round
  std::vector<std::uint32_t> turned;  // faces of the soup that are turned round, ascending
  std::size_t faces_repaired = 0;
};

namespace {

// One step from a version to the next.
template <typename State>
class RepairStep {
 public:
  RepairStep(const State& before, GrownSoup& grown)
      : before_(before),
        soup_(grown.soup),
        previous_position_(grown.previous_position),
        position_now_(positions_now(previous_position_, soup_.positions.size(), before.point.size())),
        kept_(kept_faces({before.soup_faces, soup_.faces, previous_position_, grown.previous_face})) {}

  GrownMesh run(State& after) {
    find_points();
    if (kept_.in_order) {
      find_dirty_points();
    } else {
      dirty_.assign(places_.size(), 1);
    }
    find_region();
    find_suspects();
    find_turned_faces();
    if (mark_other_turns()) find_region();
    turn_and_split();
    find_first_uses();
    GrownMesh result = compose(after);
    after.faces_repaired = faces_.size() + dropped_;
    return result;
  }

 private:
  [[nodiscard]] glm::uvec3 points_of(std::size_t face) const {
    const glm::uvec3& corners = soup_.faces[face];
    return {point_[corners.x], point_[corners.y], point_[corners.z]};
  }

  void find_points() {
    places_.resize(soup_.positions.size());
    in_parallel(places_.size(), [&](std::size_t i) { places_[i] = glm::vec3(soup_.positions[i]); });
    JoinedPositions joined = joined_positions(places_, previous_position_, position_now_, before_.point);
    point_ = std::move(joined.point);
    heirs_ = std::move(joined.heirs);
  }

  // Returns the point that a position before is now at, or none.
  [[nodiscard]] VertexId point_now(std::uint32_t position_before) const {
    const VertexId point = before_.point[position_before];
    if (point == VertexId::none || position_now_[point] != VertexId::none) {
      return point == VertexId::none ? point : point_[position_now_[point]];
    }
    const auto heir = heirs_.find(point);
    return heir == heirs_.end() ? VertexId::none : heir->second;
  }

  // Marks the points at which a face came or went. Faces that stay are in order.
  void find_dirty_points() {
    dirty_.assign(places_.size(), 0);
    const auto mark = [&](VertexId point) {
      if (point != VertexId::none) dirty_[point] = 1;
    };
    std::uint32_t next = 0;  // face before
    const auto mark_gone = [&](std::uint32_t end) {
      for (; next < end; ++next) {
        for (int corner = 0; corner < 3; ++corner) mark(point_now(before_.soup_faces[next][corner]));
      }
    };
    for (std::size_t face = 0; face < soup_.faces.size(); ++face) {
      const FaceId before = kept_.before[face];
      if (before == FaceId::none) {
        for (int corner = 0; corner < 3; ++corner) mark(point_[soup_.faces[face][corner]]);
      } else {
        mark_gone(before);
        ++next;
      }
    }
    mark_gone(static_cast<std::uint32_t>(before_.soup_faces.size()));
  }

  [[nodiscard]] bool is_in_region(std::uint32_t face) const {
    const glm::uvec3 points = points_of(face);
    return std::max({points.x, points.y, points.z}) != kAbsent &&
           (dirty_[points.x] | dirty_[points.y] | dirty_[points.z]) != 0;
  }

  // Lists the faces around dirty points that have an area and are no duplicates.
  void find_region() {
    list_region();
    number_region();
    const VertexFaces around(local_points_.size(), triangles_);
    drop(duplicate_faces(triangles_, around, vertices_without_one_fan(local_points_.size(), triangles_, around)));
  }

  // Lists the faces around dirty points, ascending.
  void list_region() {
    using Found = std::vector<std::uint32_t>;
    region_ = tbb::parallel_reduce(
        tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(soup_.faces.size()), kChunk), Found(),
        [&](const tbb::blocked_range<std::uint32_t>& range, Found found) {
          for (std::uint32_t face = range.begin(); face < range.end(); ++face) {
            if (is_in_region(face)) found.push_back(face);
          }
          return found;
        },
        [](Found first, const Found& second) {
          first.insert(first.end(), second.begin(), second.end());
          return first;
        });
  }

  [[nodiscard]] bool is_degenerate(std::size_t face) const {
    const glm::uvec3 p = points_of(face);
    return p.x == p.y || p.y == p.z || p.z == p.x || are_collinear(places_[p.x], places_[p.y], places_[p.z]);
  }

  // Lists the faces of the region that have an area, and numbers their points.
  void number_region() {
    std::vector<std::uint8_t> degenerate(region_.size(), 0);
    in_parallel(region_.size(), [&](std::size_t i) { degenerate[i] = is_degenerate(region_[i]) ? 1 : 0; });
    std::vector<std::uint32_t> number(places_.size(), kAbsent);
    local_points_.clear();
    triangles_.clear();
    faces_.clear();
    dropped_ = 0;
    for (std::size_t i = 0; i < region_.size(); ++i) {
      if (degenerate[i] != 0) {
        ++dropped_;
        continue;
      }
      const glm::uvec3 points = points_of(region_[i]);
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
      faces_.push_back(region_[i]);
    }
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

  // Returns the dirty points of the region whose faces do not form one fan. A point at its rim has not all of its faces
  // there.
  [[nodiscard]] std::vector<std::uint32_t> local_suspects(const VertexFaces& around) const {
    std::vector<std::uint32_t> suspects = vertices_without_one_fan(local_points_.size(), triangles_, around);
    std::erase_if(suspects, [&](std::uint32_t local) { return dirty_[local_points_[local]] == 0; });
    return suspects;
  }

  // Around points that are not dirty nothing has changed.
  void find_suspects() {
    suspects_.clear();
    for (const VertexId before : before_.suspects) {
      const VertexId point = point_now(before);
      if (point != VertexId::none && dirty_[point] == 0) suspects_.push_back(point);
    }
    const VertexFaces around(local_points_.size(), triangles_);
    for (const std::uint32_t local : local_suspects(around)) suspects_.emplace_back(local_points_[local]);
  }

  // Finds which faces are turned round. That depends on all.
  void find_turned_faces() {
    if (suspects_.empty()) return;
    TriangleList all(soup_.faces.size(), kNoTriangle);
    tbb::parallel_for(std::size_t{0}, chunks(), [&](std::size_t chunk) {
      for (const RunOfMesh& run : runs_of(chunk)) {
        for (std::uint32_t face = run.face; face < run.face + run.count; ++face) {
          const glm::uvec3 points = points_of(face);
          all[face] = {points.x, points.y, points.z};
        }
      }
    });
    turned_ = faces_to_turn(places_.size(), all, {suspects_.begin(), suspects_.end()});
  }

  // Marks the points of faces that stay and are turned round now or were before, not both. Returns whether there are
  // some that were not dirty.
  bool mark_other_turns() {
    bool found = false;
    const auto mark = [&](std::uint32_t point) {
      if (point != kAbsent) found = std::exchange(dirty_[point], std::uint8_t{1}) == 0 || found;
    };
    std::vector<std::uint32_t> stay;  // faces before
    for (const std::uint32_t face : turned_) {
      if (kept_.before[face] != FaceId::none) stay.push_back(kept_.before[face]);
      if (std::binary_search(before_.turned.begin(), before_.turned.end(), kept_.before[face])) continue;
      const glm::uvec3 points = points_of(face);
      for (int corner = 0; corner < 3; ++corner) mark(points[corner]);
    }
    std::sort(stay.begin(), stay.end());
    for (const std::uint32_t face : before_.turned) {
      if (std::binary_search(stay.begin(), stay.end(), face)) continue;
      for (int corner = 0; corner < 3; ++corner) mark(point_now(before_.soup_faces[face][corner]));
    }
    return found;
  }

  void turn_and_split() {
    const VertexFaces around(local_points_.size(), triangles_);
    const std::vector<std::uint32_t> suspects = local_suspects(around);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      if (is_turned(faces_[i])) std::reverse(triangles_[i].begin(), triangles_[i].end());
    }
    copies_ = split_vertices(local_points_.size(), triangles_, around, suspects).copies;
  }

  [[nodiscard]] bool is_turned(std::uint32_t face) const {
    return std::binary_search(turned_.begin(), turned_.end(), face);
  }
  [[nodiscard]] std::uint32_t point_of_local(std::uint32_t local) const {
    return local_points_[local < local_points_.size() ? local : copies_[local - local_points_.size()]];
  }
  // Returns the face of the mesh before that a face of the soup was, or none.
  [[nodiscard]] FaceId mesh_face_before(std::size_t face) const {
    return kept_.before[face] == FaceId::none ? FaceId::none : before_.mesh_face[kept_.before[face]];
  }
  // Returns which corner of the mesh's face before a corner of the mesh's face is, where a face stays. One that is
  // turned round has its corners in the opposite order of the soup's.
  [[nodiscard]] int corner_before(std::uint32_t face, int corner) const {
    const int turn = kept_.first_corner.empty() ? 0 : kept_.first_corner[face];
    if (turn == 0) return corner;
    return is_turned(face) ? 2 - (2 - corner + turn) % 3 : (corner + turn) % 3;
  }
  [[nodiscard]] bool was_first_use(std::uint32_t face, int corner) const {
    return (before_.first_uses[mesh_face_before(face)] >> corner_before(face, corner) & 1) != 0;
  }
  [[nodiscard]] std::uint32_t vertex_before(std::uint32_t face, int corner) const {
    return before_.mesh_faces[mesh_face_before(face)][corner_before(face, corner)];
  }

  // Finds at which corners of the region's faces a vertex is used first. Where it is used first at other points does
  // not change: their faces are those that they had, in their order.
  void find_first_uses() {
    std::vector<std::uint8_t> used(local_points_.size() + copies_.size(), 0);
    first_uses_.assign(faces_.size(), 0);
    for (std::size_t i = 0; i < faces_.size(); ++i) {
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t local = triangles_[i][static_cast<std::size_t>(corner)];
        const bool first = dirty_[point_of_local(local)] != 0 ? std::exchange(used[local], std::uint8_t{1}) == 0
                                                              : was_first_use(faces_[i], corner);
        first_uses_[i] |= static_cast<std::uint8_t>((first ? 1 : 0) << corner);
      }
    }
  }

  // A face of the soup that the mesh has.
  struct FaceOfMesh {
    std::uint32_t face;
    std::uint32_t i;  // its place in faces_; kAbsent: it is not there
    bool is_turned;
  };

  [[nodiscard]] std::size_t chunks() const { return (soup_.faces.size() + kChunk - 1) / kChunk; }

  [[nodiscard]] std::uint8_t first_uses(const FaceOfMesh& face) const {
    if (face.i != kAbsent) return first_uses_[face.i];
    if (kept_.first_corner.empty()) return before_.first_uses[mesh_face_before(face.face)];
    std::uint8_t uses = 0;
    for (int corner = 0; corner < 3; ++corner) {
      uses |= static_cast<std::uint8_t>((was_first_use(face.face, corner) ? 1 : 0) << corner);
    }
    return uses;
  }

  struct Numbers {
    std::vector<std::uint32_t> of_vertex_before, of_local;
  };
  [[nodiscard]] std::uint32_t& number_of(Numbers& numbers, const FaceOfMesh& face, int corner) const {
    if (face.i != kAbsent) {
      const std::uint32_t local = triangles_[face.i][static_cast<std::size_t>(corner)];
      if (dirty_[point_of_local(local)] != 0) return numbers.of_local[local];
    }
    return numbers.of_vertex_before[vertex_before(face.face, corner)];
  }

  [[nodiscard]] const glm::vec3& place_of(const FaceOfMesh& face, int corner) const {
    return places_[soup_.faces[face.face][face.is_turned ? 2 - corner : corner]];
  }

  // Faces of the soup that the mesh has, one after another in both. All of them are repaired, or all were in the mesh
  // before, one after another there too.
  struct RunOfMesh {
    std::uint32_t face, count;
    std::uint32_t i;       // place of the first in faces_; kAbsent: they are not there
    std::uint32_t before;  // of the mesh before, where they are not
    bool is_turned;
  };

  // Lists the faces of a chunk of the soup that the mesh has.
  [[nodiscard]] std::vector<RunOfMesh> runs_of(std::size_t chunk) const {
    const auto begin = static_cast<std::uint32_t>(chunk * kChunk);
    const auto end = static_cast<std::uint32_t>(std::min(soup_.faces.size(), (chunk + 1) * kChunk));
    const auto from = [&](const std::vector<std::uint32_t>& faces) {
      return static_cast<std::size_t>(std::lower_bound(faces.begin(), faces.end(), begin) - faces.begin());
    };
    const auto at = [&](const std::vector<std::uint32_t>& faces, std::size_t i) {
      return i < faces.size() ? std::min(faces[i], end) : end;
    };
    std::size_t region = from(region_), repaired = from(faces_), turned = from(turned_);
    std::vector<RunOfMesh> runs;
    for (std::uint32_t face = begin; face < end; ++face) {
      const std::uint32_t next = std::min(at(region_, region), at(turned_, turned));
      add_kept_faces(face, next, false, runs);
      if (next == end) break;
      const bool is_turned = at(turned_, turned) == next;
      if (at(region_, region) != next) add_kept_faces(next, next + 1, is_turned, runs);
      if (at(faces_, repaired) == next) add_repaired_face(next, repaired++, is_turned, runs);
      if (at(region_, region) == next) ++region;
      if (is_turned) ++turned;
      face = next;
    }
    return runs;
  }

  // Appends those of some faces of the soup that were in the mesh before.
  void add_kept_faces(std::uint32_t begin, std::uint32_t end, bool is_turned, std::vector<RunOfMesh>& runs) const {
    for (std::uint32_t face = begin; face < end;) {
      const FaceId before = mesh_face_before(face);
      std::uint32_t count = 1;
      if (before != FaceId::none) {
        while (face + count < end && mesh_face_before(face + count) == before + count) ++count;
        runs.push_back({face, count, kAbsent, before, is_turned});
      }
      face += count;
    }
  }

  void add_repaired_face(std::uint32_t face, std::size_t place, bool is_turned, std::vector<RunOfMesh>& runs) const {
    const auto i = static_cast<std::uint32_t>(place);
    if (!runs.empty() && runs.back().i != kAbsent && runs.back().face + runs.back().count == face &&
        runs.back().is_turned == is_turned) {
      ++runs.back().count;
    } else {
      runs.push_back({face, 1, i, FaceId::none, is_turned});
    }
  }

  // Calls the function with each face of a run.
  template <typename Visit>
  void for_faces_of(const RunOfMesh& run, const Visit& visit) const {
    for (std::uint32_t k = 0; k < run.count; ++k) {
      visit(FaceOfMesh{run.face + k, run.i == kAbsent ? kAbsent : run.i + k, run.is_turned});
    }
  }

  // Returns whether the faces of a run were in the mesh before with the same corner first.
  [[nodiscard]] bool is_as_before(const RunOfMesh& run) const { return run.i == kAbsent && kept_.first_corner.empty(); }
  // Returns the first uses of a run's faces as they are stored already, or null.
  [[nodiscard]] const std::uint8_t* stored_first_uses(const RunOfMesh& run) const {
    if (run.i != kAbsent) return &first_uses_[run.i];
    return is_as_before(run) ? &before_.first_uses[run.before] : nullptr;
  }

  // A chunk of the soup: the faces that the mesh has of it, and how many faces and vertices of the mesh come before.
  struct ChunkOfMesh {
    std::vector<RunOfMesh> runs;
    std::uint32_t first_face = 0, first_vertex = 0;
  };

  // Returns the chunks, and at the end an empty one.
  [[nodiscard]] std::vector<ChunkOfMesh> chunks_of_mesh() const {
    std::vector<ChunkOfMesh> all(chunks() + 1);
    tbb::parallel_for(std::size_t{0}, chunks(), [&](std::size_t chunk) {
      all[chunk].runs = runs_of(chunk);
      std::uint32_t faces = 0, vertices = 0;
      const auto add = [&](std::uint8_t uses) { vertices += static_cast<std::uint32_t>(std::popcount(uses)); };
      for (const RunOfMesh& run : all[chunk].runs) {
        faces += run.count;
        if (const std::uint8_t* const uses = stored_first_uses(run)) {
          std::for_each(uses, uses + run.count, add);
        } else {
          for_faces_of(run, [&](const FaceOfMesh& face) { add(first_uses(face)); });
        }
      }
      all[chunk + 1].first_face = faces;
      all[chunk + 1].first_vertex = vertices;
    });
    for (std::size_t chunk = 1; chunk < all.size(); ++chunk) {
      all[chunk].first_face += all[chunk - 1].first_face;
      all[chunk].first_vertex += all[chunk - 1].first_vertex;
    }
    return all;
  }

  // Numbers a chunk's faces of the mesh, and the vertices that they use first.
  void number_chunk(const ChunkOfMesh& chunk, Numbers& numbers, GrownMesh& made, State& after) const {
    std::uint32_t next_face = chunk.first_face, next_vertex = chunk.first_vertex;
    for (const RunOfMesh& run : chunk.runs) {
      list_faces(run, next_face, made, after);
      const auto use = [&](const FaceOfMesh& face, int corner, std::uint32_t& number) {
        number = next_vertex;
        made.mesh.positions[next_vertex++] = place_of(face, corner);
      };
      const std::uint8_t* uses = &after.first_uses[next_face];
      for_faces_of(run, [&](const FaceOfMesh& face) {
        const std::uint8_t of_face = *uses++;
        if (of_face == 0) return;
        for (int corner = 0; corner < 3; ++corner) {
          if ((of_face >> corner & 1) == 0) continue;
          if (is_as_before(run)) {
            use(face, corner, numbers.of_vertex_before[before_.mesh_faces[run.before + face.face - run.face][corner]]);
          } else {
            use(face, corner, number_of(numbers, face, corner));
          }
        }
      });
      next_face += run.count;
    }
  }

  // Says which faces the faces of a run were and are, from a number in the mesh on, and what they use first.
  void list_faces(const RunOfMesh& run, std::uint32_t first, GrownMesh& made, State& after) const {
    std::uint32_t next = first;
    for (std::uint32_t face = run.face; face < run.face + run.count; ++face) after.mesh_face[face] = FaceId(next++);
    next = first;
    if (run.i == kAbsent) {
      for (std::uint32_t k = 0; k < run.count; ++k) made.previous_face[next++] = FaceId(run.before + k);
    } else {
      for (std::uint32_t k = 0; k < run.count; ++k) made.previous_face[next++] = mesh_face_before(run.face + k);
    }
    std::uint8_t* to = &after.first_uses[first];
    if (const std::uint8_t* const uses = stored_first_uses(run)) {
      std::copy_n(uses, run.count, to);
    } else {
      for_faces_of(run, [&](const FaceOfMesh& face) { *to++ = first_uses(face); });
    }
  }

  // Lists the corners of a chunk's faces of the mesh, once all vertices are numbered.
  void fill_chunk(const ChunkOfMesh& chunk, Numbers& numbers, std::vector<glm::uvec3>& faces) const {
    std::uint32_t next = chunk.first_face;
    for (const RunOfMesh& run : chunk.runs) {
      if (is_as_before(run)) {
        const std::uint32_t* const number = numbers.of_vertex_before.data();
        for (std::uint32_t k = 0; k < run.count; ++k) {
          const glm::uvec3& before = before_.mesh_faces[run.before + k];
          faces[next++] = {number[before.x], number[before.y], number[before.z]};
        }
        continue;
      }
      for_faces_of(run, [&](const FaceOfMesh& face) {
        glm::uvec3& corners = faces[next++];
        for (int corner = 0; corner < 3; ++corner) corners[corner] = number_of(numbers, face, corner);
      });
    }
  }

  // Vertices are numbered as the faces use them first. Where a point is not dirty, the face that used it first before
  // is the first now. So the numbers with which a chunk begins are found by counting, and chunks are filled at once.
  GrownMesh compose(State& after) {
    const std::vector<ChunkOfMesh> all = chunks_of_mesh();
    const std::uint32_t faces = all.back().first_face, vertices = all.back().first_vertex;
    GrownMesh made;
    made.mesh.positions.resize(vertices);
    made.mesh.faces.resize(faces);
    made.previous_face.resize(faces);
    after.mesh_face.assign(soup_.faces.size(), FaceId::none);
    after.first_uses.resize(faces);
    Numbers numbers{std::vector<std::uint32_t>(before_.mesh_vertices, kAbsent),
                    std::vector<std::uint32_t>(local_points_.size() + copies_.size(), kAbsent)};
    tbb::parallel_for(std::size_t{0}, chunks(),
                      [&](std::size_t chunk) { number_chunk(all[chunk], numbers, made, after); });
    tbb::parallel_for(std::size_t{0}, chunks(),
                      [&](std::size_t chunk) { fill_chunk(all[chunk], numbers, made.mesh.faces); });
    after.mesh_faces = made.mesh.faces;
    after.mesh_vertices = made.mesh.positions.size();
    after.soup_faces = std::move(soup_.faces);
    after.point = std::move(point_);
    after.suspects = std::move(suspects_);
    after.turned = std::move(turned_);
    return made;
  }

  const State& before_;
  TriangleSoup& soup_;
  const std::vector<VertexId>& previous_position_;  // empty: none was there
  std::vector<VertexId> position_now_;              // by position before
  KeptFaces kept_;
  std::vector<glm::vec3> places_;  // of the positions
  PointOfPosition point_;
  std::unordered_map<std::uint32_t, VertexId> heirs_;  // see JoinedPositions
  std::vector<std::uint8_t> dirty_;                    // by point
  // The region, which is all faces around dirty points.
  std::vector<std::uint32_t> region_;        // faces of the soup, ascending
  std::vector<std::uint32_t> local_points_;  // that its faces have
  TriangleList triangles_;                   // of numbers of these, and of their copies
  std::vector<std::uint32_t> faces_;         // of the soup, which the triangles are
  std::vector<std::uint8_t> first_uses_;     // by triangle, as State has them
  std::size_t dropped_ = 0;                  // faces of the region
  std::vector<std::uint32_t> copies_;
  std::vector<VertexId> suspects_;     // as State has them
  std::vector<std::uint32_t> turned_;  // as State has them
};

}  // namespace

GrowingRepair::GrowingRepair() : state_(std::make_unique<State>()) {}

GrowingRepair::~GrowingRepair() = default;

GrownMesh GrowingRepair::next(GrownSoup grown) {
  check_soup(grown.soup);
  auto after = std::make_unique<State>();
  GrownMesh result = RepairStep<State>(*state_, grown).run(*after);
  if (result.mesh.faces.empty()) throw InputError("the mesh has no usable face");
  state_ = std::move(after);
  return result;
}

std::size_t GrowingRepair::faces_repaired() const {
  return state_->faces_repaired;
}

}  // namespace lumatlas
