// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/scan.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <utility>

#include "mesh/repair/decimation.h"
#include "mesh/repair/repair.h"
#include "tools/lab/synth/random.h"
#include "tools/meshing/cut/small_pieces.h"

namespace lumatlas::synth {
namespace {

using glm::dvec3;
using glm::vec3;

// The sensor, at its full resolution of kColumns.
constexpr std::uint32_t kColumns = 640;
constexpr double kFovDeg = 58;         // horizontal
constexpr double kNearest = 0.4;       // scene units
constexpr double kFarthest = 3.5;      // scene units
constexpr double kLateralNoise = 0.8;  // standard deviation of where a pixel looks, of kColumns
constexpr double kWindow = 9;          // pixels of kColumns that are matched together and so have their error in common
constexpr float kLeastCosine = 0.26F;  // cosine of the angle to the normal, 75 degrees
// The least share of the light that must come back: reflectance times cosine over squared distance. Black plastic of
// reflectance 0.03 falls below it at 2.7 units straight ahead, a dark wall of 0.2 at 3.5 units and 76 degrees.
constexpr float kLeastSignal = 0.004F;

// The operator walks the loop three times, turning all the way: looking at the floor, level, and up.
constexpr std::array<double, 3> kPitches{-0.7, -0.2, 0.3};  // radians
constexpr std::uint32_t kFrames = 64;                       // frames of each loop
constexpr double kTurns = 9;                                // in each loop: frames overlap by a quarter

enum ScanUse : std::uint64_t { kScan = 0x7363616e, kAim, kAxial };  // uses of random numbers

// Standard normal, smooth over windows of `window` >= 1 pixels: values on their grid, interpolated, at unit variance.
double correlated_noise(std::uint64_t seed, const glm::dvec2& pixel, double window) {
  const glm::dvec2 at = pixel / window;
  const glm::dvec2 low = glm::floor(at);
  const glm::dvec2 share = at - low;
  double sum = 0;
  double squares = 0;
  for (int corner = 0; corner < 4; ++corner) {
    const glm::dvec2 step(corner & 1, corner >> 1);
    const glm::dvec2 weights = glm::mix(1.0 - share, share, step);
    const glm::u64vec2 node(low + step);
    Random random(hashed(seed, node.y, node.x));
    const double weight = weights.x * weights.y;
    sum += weight * gaussian(random);
    squares += weight * weight;
  }
  return sum / std::sqrt(squares);
}

// The share of the light that falls on a surface that is scattered back, towards where it came from among others.
float scattered(const Sighting& seen, float cosine) {
  const Material& material = *seen.material;
  if (material.metal || material.emission > 0) return 0;
  const vec3 color = pattern_color(material, coordinates(*seen.surface, seen.point), seen.surface->size);
  const float mirrored =
      material.gloss > 0 ? material.gloss + (1 - material.gloss) * std::pow(1 - cosine, 5.0F) : 0;  // Schlick
  return (1 - mirrored) * (color.x + color.y + color.z) / 3;
}

bool comes_back(const Sighting& seen, const dvec3& center) {
  const vec3 way = seen.point - vec3(center);
  const float squared = glm::dot(way, way);
  const float cosine = -glm::dot(way, seen.normal) / std::sqrt(squared);
  return cosine >= kLeastCosine && scattered(seen, cosine) * cosine / squared >= kLeastSignal;
}

float measured_depth(const Tracer& tracer, const Camera& camera, const glm::dvec2& pixel, std::uint64_t seed) {
  const double scale = static_cast<double>(camera.width) / kColumns;
  Random random(hashed(seed, kAim, static_cast<std::uint64_t>(pixel.y), static_cast<std::uint64_t>(pixel.x)));
  const double aside = kLateralNoise * scale * gaussian(random);
  const glm::dvec2 aim = pixel + glm::dvec2(aside, kLateralNoise * scale * gaussian(random));
  const std::optional<Sighting> seen = tracer.sighting_at(camera, aim);
  if (!seen || !comes_back(*seen, camera.center())) return 0;
  const double depth = camera.cam_from_world(seen->point).z;
  const double noise = correlated_noise(hashed(seed, kAxial), pixel, std::max(1.0, kWindow * scale));
  const double measured = depth + axial_noise(depth) * noise;
  return measured >= kNearest && measured <= kFarthest ? static_cast<float>(measured) : 0;
}

// From the surface's normals, how many grid edges of a unit grid a unit of it crosses.
double edges_per_area(const Mesh& mesh) {
  double edges = 0;
  for (const glm::uvec3& f : mesh.faces) {
    const dvec3 a(mesh.positions[f.x]);
    const dvec3 normal = glm::cross(dvec3(mesh.positions[f.y]) - a, dvec3(mesh.positions[f.z]) - a);
    edges += 0.5 * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z));
  }
  return edges;
}

// The voxels' side for about `faces` faces, of which there are two at each edge of the grid that the surface crosses
// where it was seen.
double voxel_for_faces(const Mesh& surface, double faces) {
  constexpr double kSeen = 0.7;  // share of the surface, about
  return std::sqrt(2 * kSeen * edges_per_area(surface) / faces);
}

// Returns cameras with enough pixels to tell the voxels apart at a middling distance, and no more than the sensor has.
std::vector<Camera> sensor_cameras(const Scene& scene, double voxel) {
  constexpr double kMiddling = 2;  // scene units
  Scene route;
  route.walk = scene.walk;
  SynthOptions options;
  options.views = kFrames;
  options.fov_deg = kFovDeg;
  const double columns = 2 * kMiddling * std::tan(glm::radians(0.5 * kFovDeg)) / voxel;
  options.width = 4 * static_cast<std::uint32_t>(std::clamp(columns, 128.0, static_cast<double>(kColumns)) / 4);
  options.height = options.width / 4 * 3;
  std::vector<Camera> cameras;
  for (const double pitch : kPitches) {
    route.walk_gaze = {.start = pitch, .turns = kTurns, .level = pitch, .nod = 0.1};
    const std::vector<Camera> loop = cameras_on_walk(route, options);
    cameras.insert(cameras.end(), loop.begin(), loop.end());
  }
  return cameras;
}

// Small pieces are dropped, as programs for scans do: what floats in the air is rarely there.
TriangleSoup without_crumbs(TriangleSoup soup) {
  constexpr std::size_t kFewest = 100;  // faces of a piece
  (void)remove_small_pieces(soup, kFewest);
  return soup;
}

}  // namespace

double axial_noise(double depth) {
  return 0.0012 + 0.0019 * (depth - 0.4) * (depth - 0.4);
}

DepthImage depth_image(const Tracer& tracer, const Camera& camera, std::uint64_t seed) {
  DepthImage image{camera, std::vector<float>(std::size_t{camera.width} * camera.height, 0)};
  tbb::parallel_for(std::uint32_t{0}, camera.height, [&](std::uint32_t y) {
    for (std::uint32_t x = 0; x < camera.width; ++x) {
      image.depth[std::size_t{y} * camera.width + x] = measured_depth(tracer, camera, {x + 0.5, y + 0.5}, seed);
    }
  });
  return image;
}

Mesh scanned(const Scene& scene, const Tracer& tracer, const SynthOptions& options) {
  // Voxels cut flat and curved parts alike, edge collapses do not: for a few faces more voxels are worth their time.
  constexpr double kVoxelFaces = 8;          // per face that is asked for,
  constexpr double kFewestVoxelFaces = 2e4;  // lower limit of that number
  constexpr double kMostVoxelFaces = 2e6;    // and no more than are asked for beyond this
  const double asked = options.triangles;
  const double faces = std::max(asked, std::clamp(kVoxelFaces * asked, kFewestVoxelFaces, kMostVoxelFaces));
  FusionOptions fusion;
  fusion.voxel = voxel_for_faces(scene.geometry.mesh, faces);
  fusion.truncation = std::max(3 * fusion.voxel, 0.03);  // five times the noise at 2.5 units
  fusion.least_weight = 0.3;                             // one image from 1.8 units, or four from 3.5
  std::vector<DepthImage> images;
  for (const Camera& camera : sensor_cameras(scene, fusion.voxel)) {
    images.push_back(depth_image(tracer, camera, hashed(options.seed, kScan, images.size())));
  }
  const Mesh mesh = repair(without_crumbs(fused(images, fusion)), dvec3(0.0)).mesh;
  return mesh.faces.size() > options.triangles ? decimated(mesh, options.triangles) : mesh;
}

}  // namespace lumatlas::synth
