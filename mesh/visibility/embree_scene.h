// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by all ray casting (Embree 3): the device, a mesh as a scene, and packets of rays.
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <type_traits>

#include "mesh/base/id.h"
#include "mesh/mesh.h"

namespace lumatlas {

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
template <typename Handle>
using EmbreeHandle = std::unique_ptr<std::remove_pointer_t<Handle>, EmbreeRelease>;
using EmbreeDevice = EmbreeHandle<RTCDevice>;
using EmbreeScene = EmbreeHandle<RTCScene>;

// With the settings of the environment variable LUMATLAS_EMBREE, if there is one, in Embree's syntax: isa=sse2, for
// example, traces as on a processor that has no more. Throws std::runtime_error where Embree cannot start or refuses
// them.
[[nodiscard]] EmbreeDevice make_embree_device();

// Robust: no ray leaks through the shared edge of two faces. The mesh is copied. Throws std::runtime_error if Embree
// fails, for want of memory for example.
[[nodiscard]] EmbreeScene make_embree_scene(RTCDevice device, const Mesh& mesh, RTCBuildQuality quality);

// A mesh that rays are cast at: one scene of all faces, or one of instances, which have parts of the faces.
struct TracedMesh {
  RTCScene scene = nullptr;
  // Empty for a scene of all faces. Of instances: the faces of the mesh, part by part, and where each part begins.
  std::span<const FaceId> faces = {};
  std::span<const std::uint32_t> first = {};

  [[nodiscard]] FaceId face(std::uint32_t instance, std::uint32_t primitive) const {
    return faces.empty() ? FaceId{primitive} : faces[first[instance] + primitive];
  }
};

// Returns a scene of other scenes of the same device, each as it is, whose instance number is its place in the list.
// They must outlive it. Throws as make_embree_scene().
[[nodiscard]] EmbreeScene make_embree_instances(RTCDevice device, std::span<const RTCScene> parts);

// Coherent rays, those that are near each other, to be traced together.
//
// Embree looks at `active` only where the processor has as many lanes. Elsewhere it takes a packet for a stream, in
// which every number must be good, and traces what does not end before it starts. So all rays begin inactive in that
// way too.
struct alignas(64) EmbreePacket {
  static constexpr std::uint32_t kRays = 16;

  EmbreePacket();
  // `reach` is in lengths of the direction, >= 0. Origin and direction must be finite and below Embree's bound:
  // is_traceable().
  void set(std::uint32_t ray, const glm::vec3& origin, const glm::vec3& direction, float reach);

  // Sets hits.hit.geomID to another value than RTC_INVALID_GEOMETRY_ID for each ray that hits, and hits.ray.tfar to the
  // distance in lengths of the direction.
  void intersect(RTCScene scene);
  // Sets hits.ray.tfar to -infinity for each ray that is blocked.
  void occlude(RTCScene scene);

  RTCRayHit16 hits;
  alignas(64) int active[kRays];  // -1 or 0
};

// False for NaN, and beyond Embree's own bound FLT_LARGE: a build of it with assertions ends the program over such a
// ray.
[[nodiscard]] bool is_traceable(const glm::vec3& v);

}  // namespace lumatlas
