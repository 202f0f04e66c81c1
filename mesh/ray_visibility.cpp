// SPDX-License-Identifier: GPL-3.0-or-later
// Visibility by ray casting: 4x4 packets of coherent primary rays through pixel centres (Embree 3).
#include "mesh/ray_visibility.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>

namespace lumatlas {

namespace {

constexpr std::uint32_t kPacketSide = 4;
constexpr std::uint32_t kPacketRays = kPacketSide * kPacketSide;

// Embree's own bound, FLT_LARGE: a build of it with assertions ends the program over a ray beyond. Such a ray, of a
// camera at the end of the universe or with a vanishing focal length, sees nothing.
constexpr float kLargestCoordinate = 1.844e18f;

bool is_traceable(const glm::vec3& v) {  // false for NaN
  return std::abs(v.x) < kLargestCoordinate && std::abs(v.y) < kLargestCoordinate && std::abs(v.z) < kLargestCoordinate;
}

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseGeometry {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using GeometryHandle = std::unique_ptr<std::remove_pointer_t<RTCGeometry>, ReleaseGeometry>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

void throw_on_error(RTCDevice device, const char* what) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) {
    throw std::runtime_error("ray casting: Embree reports error " + std::to_string(error) + " while " + what);
  }
}

void attach_triangles(RTCDevice device, RTCScene scene, const Mesh& mesh) {
  const GeometryHandle geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  void* vertices = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           sizeof(glm::vec3), std::max<std::size_t>(mesh.positions.size(), 1));
  void* indices = rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          sizeof(glm::uvec3), std::max<std::size_t>(mesh.faces.size(), 1));
  throw_on_error(device, "allocating the mesh");
  std::memcpy(vertices, mesh.positions.data(), mesh.positions.size() * sizeof(glm::vec3));
  std::memcpy(indices, mesh.faces.data(), mesh.faces.size() * sizeof(glm::uvec3));
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene, geometry.get());  // the scene keeps it from here on
}

}  // namespace

class RayVisibility::Tree {
 public:
  explicit Tree(const Mesh& mesh) {
    if (mesh.faces.empty()) throw std::invalid_argument("ray casting: the mesh has no faces, must have at least one");
    device_.reset(rtcNewDevice("verbose=0"));
    if (!device_) throw std::runtime_error("ray casting: Embree cannot start on this processor");
    scene_.reset(rtcNewScene(device_.get()));
    // Robust: no rays leak through the shared edges of faces.
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_ROBUST);
    attach_triangles(device_.get(), scene_.get(), mesh);
    rtcCommitScene(scene_.get());
    throw_on_error(device_.get(), "building its tree");
  }

  // `wanted` as of trace_part(); empty: everything.
  void trace(const Camera& camera, std::span<const std::uint8_t> wanted, VisibilityBuffer& buffer) const {
    check(camera);
    buffer.width = camera.width;
    buffer.height = camera.height;
    const std::size_t pixels = std::size_t{camera.width} * camera.height;
    buffer.depth.resize(pixels);
    buffer.face.resize(pixels);
    const std::uint32_t columns = (camera.width + kPacketSide - 1) / kPacketSide;
    const std::uint32_t rows = (camera.height + kPacketSide - 1) / kPacketSide;
    tbb::parallel_for(tbb::blocked_range2d<std::uint32_t>(0, rows, 4, 0, columns, 16),
                      [&](const tbb::blocked_range2d<std::uint32_t>& block) {
                        for (std::uint32_t row = block.rows().begin(); row != block.rows().end(); ++row) {
                          for (std::uint32_t column = block.cols().begin(); column != block.cols().end(); ++column) {
                            trace_packet(camera, wanted, column * kPacketSide, row * kPacketSide, buffer);
                          }
                        }
                      });
  }

 private:
  void trace_packet(const Camera& camera, std::span<const std::uint8_t> wanted, std::uint32_t left, std::uint32_t top,
                    VisibilityBuffer& buffer) const {
    alignas(64) RTCRayHit16 packet;
    alignas(64) int active[kPacketRays];
    const glm::vec3 origin(camera.center());
    bool any_wanted = false;
    for (std::uint32_t i = 0; i < kPacketRays; ++i) {
      const std::uint32_t x = left + i % kPacketSide;
      const std::uint32_t y = top + i / kPacketSide;
      // Not unit but one deep, so that the hit's distance along it is its depth.
      const glm::vec3 direction(camera.ray({x + 0.5, y + 0.5}));
      const bool in_image = x < camera.width && y < camera.height;
      any_wanted = any_wanted || (in_image && (wanted.empty() || wanted[std::size_t{y} * camera.width + x] != 0));
      active[i] = in_image && is_traceable(origin) && is_traceable(direction) ? -1 : 0;
      packet.ray.org_x[i] = origin.x;
      packet.ray.org_y[i] = origin.y;
      packet.ray.org_z[i] = origin.z;
      packet.ray.dir_x[i] = direction.x;
      packet.ray.dir_y[i] = direction.y;
      packet.ray.dir_z[i] = direction.z;
      packet.ray.tnear[i] = 0;
      packet.ray.tfar[i] = std::numeric_limits<float>::infinity();
      packet.ray.time[i] = 0;
      packet.ray.mask[i] = ~0u;
      packet.ray.flags[i] = 0;
      packet.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    // All rays of a packet or none, for what one of them hits may depend, by rounding, on the others.
    if (any_wanted) rtcIntersect16(active, scene_.get(), &context, &packet);
    for (std::uint32_t i = 0; i < kPacketRays; ++i) {
      const std::uint32_t x = left + i % kPacketSide;
      const std::uint32_t y = top + i / kPacketSide;
      if (x >= camera.width || y >= camera.height) continue;
      const std::size_t pixel = std::size_t{y} * camera.width + x;
      const bool hit = packet.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID && (wanted.empty() || wanted[pixel] != 0);
      buffer.depth[pixel] = hit ? packet.ray.tfar[i] : std::numeric_limits<float>::infinity();
      buffer.face[pixel] = hit ? packet.hit.primID[i] : kNoFace;
    }
  }

  DeviceHandle device_;
  SceneHandle scene_;
};

RayVisibility::RayVisibility(const Mesh& mesh) : tree_(std::make_unique<const Tree>(mesh)) {}

RayVisibility::~RayVisibility() = default;

void RayVisibility::trace(const Camera& camera, VisibilityBuffer& buffer) const {
  tree_->trace(camera, {}, buffer);
}

void RayVisibility::trace_part(const Camera& camera, std::span<const std::uint8_t> wanted,
                               VisibilityBuffer& buffer) const {
  if (wanted.size() != std::size_t{camera.width} * camera.height) {
    throw std::invalid_argument("ray casting: wanted has " + std::to_string(wanted.size()) +
                                " values, must have one per pixel of " + std::to_string(camera.width) + "x" +
                                std::to_string(camera.height));
  }
  tree_->trace(camera, wanted, buffer);
}

std::unique_ptr<Visibility> make_ray_visibility(const Mesh& mesh) {
  return std::make_unique<RayVisibility>(mesh);
}

}  // namespace lumatlas
