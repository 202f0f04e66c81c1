// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/embree_scene.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

constexpr float kLargestCoordinate = 1.844e18f;  // Embree's FLT_LARGE
constexpr const char* kSettings = "LUMATLAS_EMBREE";

void throw_on_error(RTCDevice device, const std::string& what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error("ray casting: Embree reports error " + std::to_string(error) + " while " + what);
}

void place(RTCRay16& rays, std::uint32_t ray, const glm::vec3& origin, const glm::vec3& direction, float reach) {
  rays.org_x[ray] = origin.x;
  rays.org_y[ray] = origin.y;
  rays.org_z[ray] = origin.z;
  rays.dir_x[ray] = direction.x;
  rays.dir_y[ray] = direction.y;
  rays.dir_z[ray] = direction.z;
  rays.tnear[ray] = 0;
  rays.tfar[ray] = reach;
}

RTCIntersectContext coherent() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

}  // namespace

EmbreeDevice make_embree_device() {
  const char* settings = std::getenv(kSettings);
  EmbreeDevice device(rtcNewDevice(settings));
  if (!device) {
    // Embree's own error tells the cause; the processor is blamed only if it is the cause.
    const RTCError error = rtcGetDeviceError(nullptr);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_UNSUPPORTED_CPU && error != RTC_ERROR_INVALID_ARGUMENT) {
      throw std::runtime_error("ray casting: Embree cannot start (its error " + std::to_string(error) +
                               "): memory, threads or stack may be limited too much");
    }
    throw std::runtime_error("ray casting: Embree cannot start on this processor" +
                             (settings ? std::string(" with ") + kSettings + "=" + settings : std::string()));
  }
  return device;
}

EmbreeScene make_embree_scene(RTCDevice device, const Mesh& mesh, RTCBuildQuality quality) {
  EmbreeScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene.get(), quality);
  const EmbreeHandle<RTCGeometry> geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  void* positions = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            sizeof(glm::vec3), std::max<std::size_t>(mesh.positions.size(), 1));
  void* faces = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3),
                                        std::max<std::size_t>(mesh.faces.size(), 1));
  throw_on_error(device, "allocating the mesh");
  std::memcpy(positions, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
  std::memcpy(faces, mesh.faces.data(), mesh.faces.size() * sizeof(glm::uvec3));
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene.get(), geometry.get());  // the scene keeps it from here on
  rtcCommitScene(scene.get());
  throw_on_error(device, "building its tree");
  return scene;
}

EmbreeScene make_embree_instances(RTCDevice device, std::span<const RTCScene> parts) {
  EmbreeScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const EmbreeHandle<RTCGeometry> instance(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
    rtcSetGeometryInstancedScene(instance.get(), parts[part]);
    rtcCommitGeometry(instance.get());
    rtcAttachGeometryByID(scene.get(), instance.get(), static_cast<unsigned>(part));
  }
  rtcCommitScene(scene.get());
  throw_on_error(device, "building a tree of parts");
  return scene;
}

EmbreePacket::EmbreePacket() {
  for (std::uint32_t ray = 0; ray < kRays; ++ray) {
    place(hits.ray, ray, glm::vec3(0), glm::vec3(0, 0, 1), -1);
    hits.ray.time[ray] = 0;
    hits.ray.mask[ray] = ~0u;
    hits.ray.id[ray] = hits.ray.flags[ray] = 0;
    hits.hit.geomID[ray] = hits.hit.instID[0][ray] = RTC_INVALID_GEOMETRY_ID;
    active[ray] = 0;
  }
}

void EmbreePacket::set(std::uint32_t ray, const glm::vec3& origin, const glm::vec3& direction, float reach) {
  place(hits.ray, ray, origin, direction, reach);
  active[ray] = -1;
}

void EmbreePacket::intersect(RTCScene scene) {
  RTCIntersectContext context = coherent();
  rtcIntersect16(active, scene, &context, &hits);
}

void EmbreePacket::occlude(RTCScene scene) {
  RTCIntersectContext context = coherent();
  rtcOccluded16(active, scene, &context, &hits.ray);
}

bool is_traceable(const glm::vec3& v) {
  return std::abs(v.x) < kLargestCoordinate && std::abs(v.y) < kLargestCoordinate && std::abs(v.z) < kLargestCoordinate;
}

}  // namespace lumatlas
