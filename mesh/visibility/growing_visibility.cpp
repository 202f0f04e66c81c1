// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/growing_visibility.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <stdexcept>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh/base/requirement.h"
#include "mesh/visibility/ray_visibility.h"
#include "mesh/visibility/traced_parts.h"

namespace lumatlas {

namespace {

constexpr Requirement growing_visibility_requires{"growing visibility"};

// Cubes farther than this from the origin share the last one's number.
constexpr double kFarthestCube = (1 << 20) - 1;

std::uint64_t cube_key(const glm::vec3& corner, double side) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    // Cubes lie about the middles of the axes' whole numbers: a wall through the origin is in one of them.
    const double cube = std::clamp(std::round(corner[axis] / side), -kFarthestCube, kFarthestCube);
    key = (key << 21U) | static_cast<std::uint64_t>(cube + kFarthestCube);
  }
  return key;
}

// The faces of a mesh, cube by cube, each cube's in the order of the mesh.
struct CubedFaces {
  std::vector<std::uint64_t> keys;   // of the cubes, in the order of their first faces
  std::vector<std::uint32_t> first;  // by cube, where its faces begin; and their number at the end
  std::vector<FaceId> faces;
};

CubedFaces cubed_faces(const Mesh& mesh, double side) {
  std::vector<std::uint64_t> key(mesh.faces.size());
  tbb::parallel_for(std::size_t{0}, mesh.faces.size(),
                    [&](std::size_t face) { key[face] = cube_key(mesh.positions[mesh.faces[face].x], side); });
  CubedFaces result;
  std::unordered_map<std::uint64_t, std::uint32_t> number;
  std::vector<std::uint32_t> cube(mesh.faces.size());
  std::vector<std::uint32_t> count;
  for (std::size_t face = 0; face < key.size(); ++face) {
    if (face > 0 && key[face] == key[face - 1]) {
      cube[face] = cube[face - 1];
    } else {
      const auto [entry, added] = number.emplace(key[face], static_cast<std::uint32_t>(count.size()));
      cube[face] = entry->second;
      if (added) {
        count.push_back(0);
        result.keys.push_back(key[face]);
      }
    }
    ++count[cube[face]];
  }
  result.first.push_back(0);
  for (const std::uint32_t faces : count) result.first.push_back(result.first.back() + faces);
  std::vector<std::uint32_t> next(result.first.begin(), result.first.end() - 1);
  result.faces.resize(mesh.faces.size());
  for (std::uint32_t face = 0; face < cube.size(); ++face) result.faces[next[cube[face]]++] = FaceId{face};
  return result;
}

// Returns whether the faces of a part are at the same places as these of a mesh, in the same order. How they share
// vertices does not matter to rays.
bool are_at_same_places(const Mesh& mesh, std::span<const FaceId> faces, const Mesh& part) {
  if (faces.size() != part.faces.size()) return false;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const glm::uvec3 &now = mesh.faces[faces[i]], &before = part.faces[i];
    for (int corner = 0; corner < 3; ++corner) {
      if (mesh.positions[now[corner]] != part.positions[before[corner]]) return false;
    }
  }
  return true;
}

// Makes meshes of some of the faces of a mesh.
class PartMaker {
 public:
  explicit PartMaker(const Mesh& mesh) : mesh_(mesh), number_(mesh.positions.size(), kUnnumbered) {}

  Mesh part(std::span<const FaceId> faces) {
    Mesh part;
    part.faces.reserve(faces.size());
    for (const FaceId face : faces) part.faces.push_back(numbered(face));
    part.positions.reserve(vertices_.size());
    for (const std::uint32_t vertex : vertices_) part.positions.push_back(mesh_.positions[vertex]);
    forget_numbers();
    return part;
  }

 private:
  // Returns the face with its vertices numbered as the faces of a part name them first.
  glm::uvec3 numbered(FaceId face) {
    glm::uvec3 corners = mesh_.faces[face];
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& number = number_[corners[corner]];
      if (number == kUnnumbered) {
        number = static_cast<std::uint32_t>(vertices_.size());
        vertices_.push_back(corners[corner]);
      }
      corners[corner] = number;
    }
    return corners;
  }
  void forget_numbers() {
    for (const std::uint32_t vertex : vertices_) number_[vertex] = kUnnumbered;
    vertices_.clear();
  }

  static constexpr std::uint32_t kUnnumbered = std::numeric_limits<std::uint32_t>::max();
  const Mesh& mesh_;
  std::vector<std::uint32_t> number_;    // by vertex, in the part that is made
  std::vector<std::uint32_t> vertices_;  // of that part, in the order of their numbers
};

}  // namespace

struct GrowingVisibility::State {
  double side = 0;
  std::shared_ptr<const EmbreeDevice> device;
  std::unordered_map<std::uint64_t, std::shared_ptr<const TracedPart>> parts;  // of the last version
  std::size_t made = 0;
};

GrowingVisibility::GrowingVisibility(double side) : state_(std::make_unique<State>()) {
  growing_visibility_requires(std::isfinite(side) && side > 0, "side", side, "finite and above 0");
  state_->side = side;
}

GrowingVisibility::~GrowingVisibility() = default;

std::unique_ptr<Visibility> GrowingVisibility::of(const Mesh& mesh) {
  check(mesh);
  if (mesh.faces.empty()) throw std::invalid_argument("ray casting: the mesh has no faces, must have at least one");
  State& state = *state_;
  if (!state.device) state.device = std::make_shared<const EmbreeDevice>(make_embree_device());
  CubedFaces cubes = cubed_faces(mesh, state.side);
  TracedParts traced;
  traced.device = state.device;
  traced.parts.resize(cubes.keys.size());
  tbb::enumerable_thread_specific<PartMaker> makers([&] { return PartMaker(mesh); });
  std::atomic<std::size_t> made = 0;
  tbb::parallel_for(std::size_t{0}, cubes.keys.size(), [&](std::size_t cube) {
    const std::span<const FaceId> faces(cubes.faces.data() + cubes.first[cube],
                                        cubes.first[cube + 1] - cubes.first[cube]);
    const auto before = state.parts.find(cubes.keys[cube]);
    if (before != state.parts.end() && are_at_same_places(mesh, faces, before->second->mesh)) {
      traced.parts[cube] = before->second;
      return;
    }
    Mesh part = makers.local().part(faces);
    ++made;
    auto anew = std::make_shared<TracedPart>();
    anew->scene = make_embree_scene(state.device->get(), part, RTC_BUILD_QUALITY_MEDIUM);
    anew->mesh = std::move(part);
    traced.parts[cube] = std::move(anew);
  });
  std::vector<RTCScene> scenes;
  scenes.reserve(traced.parts.size());
  for (const auto& part : traced.parts) scenes.push_back(part->scene.get());
  traced.scene = make_embree_instances(state.device->get(), scenes);
  state.parts.clear();
  for (std::size_t cube = 0; cube < cubes.keys.size(); ++cube) state.parts[cubes.keys[cube]] = traced.parts[cube];
  state.made = made;
  traced.faces = std::move(cubes.faces);
  traced.first = std::move(cubes.first);
  return std::make_unique<RayVisibility>(std::move(traced));
}

std::size_t GrowingVisibility::cubes() const {
  return state_->parts.size();
}

std::size_t GrowingVisibility::cubes_made() const {
  return state_->made;
}

}  // namespace lumatlas
