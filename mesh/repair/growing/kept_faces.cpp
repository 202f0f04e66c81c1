// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/repair/growing/kept_faces.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <tuple>

namespace lumatlas {

namespace {

[[noreturn]] void refuse_previous_face(const std::string& complaint) {
  throw std::invalid_argument("growing repair: previous_face " + complaint);
}

glm::uvec3 corners_before(const SoupVersions& versions, std::size_t face) {
  const glm::uvec3& f = versions.faces[face];
  return {versions.previous_position[f.x], versions.previous_position[f.y], versions.previous_position[f.z]};
}

// Returns the first face that names one with other corners; the number of faces if there is none.
std::size_t first_misnamed(const SoupVersions& versions) {
  const std::size_t count = versions.faces.size();
  const auto search = [&](const tbb::blocked_range<std::size_t>& range, std::size_t found) {
    for (std::size_t face = range.begin(); face < range.end() && face < found; ++face) {
      const FaceId before = versions.previous_face[face];
      if (before != FaceId::none && versions.faces_before[before] != corners_before(versions, face)) return face;
    }
    return found;
  };
  return tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, count, 1 << 14), count, search,
                              [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

void check_previous_faces(const SoupVersions& versions) {
  if (versions.previous_face.size() != versions.faces.size()) {
    refuse_previous_face("has " + std::to_string(versions.previous_face.size()) + " entries, must be empty or have " +
                         std::to_string(versions.faces.size()));
  }
  const std::size_t count_before = versions.faces_before.size();
  std::uint32_t next = 0;  // face before
  for (const FaceId before : versions.previous_face) {
    if (before == FaceId::none) continue;
    if (before >= count_before) {
      refuse_previous_face("names " + std::to_string(before) + " of " + std::to_string(count_before));
    }
    if (before < next) refuse_previous_face("names " + std::to_string(before) + " after " + std::to_string(next - 1));
    next = before + 1;
  }
  if (versions.previous_position.empty()) {
    if (next > 0) refuse_previous_face("names " + std::to_string(next - 1) + ", whose positions are all new");
    return;
  }
  const std::size_t wrong = first_misnamed(versions);
  if (wrong < versions.faces.size()) {
    refuse_previous_face("names " + std::to_string(versions.previous_face[wrong]) + " at face " +
                         std::to_string(wrong) + ", which has other corners");
  }
}

// The faces that the soup's maker has not matched, ascending.
struct Unmatched {
  std::vector<std::uint32_t> before, now;
};

Unmatched unmatched_faces(const std::vector<FaceId>& previous_face, std::size_t faces_before) {
  Unmatched faces;
  std::uint32_t next = 0;  // face before
  for (std::uint32_t face = 0; face < previous_face.size(); ++face) {
    const std::uint32_t before = previous_face[face];
    if (before == FaceId::none) {
      faces.now.push_back(face);
      continue;
    }
    for (; next < before; ++next) faces.before.push_back(next);
    ++next;
  }
  for (; next < faces_before; ++next) faces.before.push_back(next);
  return faces;
}

// A face's corners as they were, turned so that the lowest comes first.
struct TurnedFace {
  std::uint32_t lowest, second, third, face;
  std::uint8_t first_corner;  // of the face, among these
  [[nodiscard]] auto corners() const { return std::tie(lowest, second, third); }
  bool operator<(const TurnedFace& other) const {
    return std::tie(lowest, second, third, face) < std::tie(other.lowest, other.second, other.third, other.face);
  }
};

TurnedFace turned_face(const glm::uvec3& f, std::uint32_t face) {
  if (f.x <= f.y && f.x <= f.z) return {f.x, f.y, f.z, face, 0};
  if (f.y <= f.z) return {f.y, f.z, f.x, face, 2};
  return {f.z, f.x, f.y, face, 1};
}

// Returns whether there was a match.
bool match_by_corners(const SoupVersions& versions, const Unmatched& unmatched, KeptFaces& kept) {
  std::vector<TurnedFace> then, now;
  for (const std::uint32_t face : unmatched.now) {
    const glm::uvec3 corners = corners_before(versions, face);
    if (std::max({corners.x, corners.y, corners.z}) != VertexId::none) now.push_back(turned_face(corners, face));
  }
  if (now.empty()) return false;
  bool found = false;
  for (const std::uint32_t face : unmatched.before) then.push_back(turned_face(versions.faces_before[face], face));
  tbb::parallel_sort(then);
  tbb::parallel_sort(now);
  for (auto face = now.begin(), old_face = then.begin(); face != now.end() && old_face != then.end();) {
    if (face->corners() == old_face->corners()) {
      kept.before[face->face] = FaceId(old_face->face);
      found = true;
      const auto turn = static_cast<std::uint8_t>((3 + face->first_corner - old_face->first_corner) % 3);
      if (turn != 0) {
        kept.first_corner.resize(kept.before.size(), 0);
        kept.first_corner[face->face] = turn;
      }
      ++face;
      ++old_face;
    } else if (face->corners() < old_face->corners()) {
      ++face;
    } else {
      ++old_face;
    }
  }
  return found;
}

bool ascends(const std::vector<FaceId>& faces) {
  std::uint32_t last = 0;
  for (const FaceId face : faces) {
    if (face == FaceId::none) continue;
    if (face < last) return false;
    last = face;
  }
  return true;
}

}  // namespace

KeptFaces kept_faces(const SoupVersions& versions) {
  const std::size_t count = versions.faces.size();
  KeptFaces kept;
  if (versions.previous_face.empty()) {
    kept.before.assign(count, FaceId::none);
  } else {
    check_previous_faces(versions);
    kept.before.assign(versions.previous_face.begin(), versions.previous_face.end());
  }
  if (versions.previous_position.empty()) return kept;
  // Faces that the maker names ascend.
  if (match_by_corners(versions, unmatched_faces(kept.before, versions.faces_before.size()), kept)) {
    kept.in_order = ascends(kept.before);
  }
  return kept;
}

}  // namespace lumatlas
