// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel reflectance: Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
// Two-dimensional Fibonacci lattices with a random shift: Cranley, Patterson, "Randomization of number theoretic
// methods for multiple integration", 1976.
#include "tools/synth_tracer.h"

#include <embree3/rtcore.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "tools/synth_random.h"

namespace lumatlas::synth {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float kOffset = 2e-4F;  // rays start this far off the surface, scene units: above float noise at 10 units
constexpr float kOcclusionReach = 0.7F;  // how far ambient occlusion looks, scene units
constexpr float kBrightest = 2.0F;       // of one path: lamps stay white, their edges and reflections stay smooth
constexpr float kNearest = 0.6F;         // lights are no nearer than this, scene units: else their frames are all noise
constexpr float kNegligible = 1e-3F;     // of a light's part of white: no shadow ray

struct DeviceRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using RtcScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

void require_no_error(RTCDevice device) {
  const RTCError error = rtcGetDeviceError(device);
  if (error != RTC_ERROR_NONE) throw std::runtime_error("Embree failed with error " + std::to_string(error));
}

template <typename T>
T* new_buffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::size_t count) {
  return static_cast<T*>(rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count));
}

RtcScene make_rtc_scene(RTCDevice device, const Mesh& mesh) {
  RtcScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // no ray slips between two faces
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = new_buffer<vec3>(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions.size());
  auto* faces = new_buffer<glm::uvec3>(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.faces.size());
  if (positions != nullptr && faces != nullptr) {
    std::copy(mesh.positions.begin(), mesh.positions.end(), positions);
    std::copy(mesh.faces.begin(), mesh.faces.end(), faces);
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  // Built by one thread: the order of a leaf's triangles decides which of two is hit on their common edge.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  rtcCommitScene(scene.get());
  require_no_error(device);
  return scene;
}

// A pixel's random numbers: for each purpose, `count` points of the unit square, evenly spread and in random order.
class PixelSamples {
 public:
  PixelSamples(std::size_t purposes, std::uint32_t count) : count_(count), points_(purposes * count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      constexpr double kGolden = 0.6180339887498949;
      const double turn = i * kGolden;
      lattice_.emplace_back((static_cast<float>(i) + 0.5F) / static_cast<float>(count),
                            static_cast<float>(turn - std::floor(turn)));
    }
  }

  void reset(std::uint64_t seed) {
    Random random(seed);
    for (std::size_t first = 0; first < points_.size(); first += count_) {
      const vec2 shift{random.uniform(), random.uniform()};  // in this order: braces
      for (std::uint32_t i = 0; i < count_; ++i) {
        const std::uint32_t place = random.below(i + 1);  // the inside-out shuffle of Fisher and Yates
        points_[first + i] = points_[first + place];
        points_[first + place] = wrapped(lattice_[i] + shift);
      }
    }
  }

  [[nodiscard]] const vec2& point(std::size_t purpose, std::uint32_t sample) const {
    return points_[purpose * count_ + sample];
  }

 private:
  static vec2 wrapped(const vec2& v) { return {v.x < 1 ? v.x : v.x - 1, v.y < 1 ? v.y : v.y - 1}; }  // of [0, 2)

  std::uint32_t count_;
  std::vector<vec2> lattice_;  // of Fibonacci
  std::vector<vec2> points_;
};

// Purposes, by number. The lights' follow: first those of what is seen directly, then of what is seen reflected.
enum Purpose : std::size_t { kPixel, kLobe, kOcclusion, kFirstLight };

vec2 in_disk(const vec2& square) {
  const float radius = std::sqrt(square.x);
  const float angle = 2 * std::numbers::pi_v<float> * square.y;
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

// A direction on the hemisphere around unit n, by the cosine's density.
vec3 around(const vec3& n, const vec2& square) {
  const vec2 disk = in_disk(square);
  const vec3 helper = std::abs(n.x) > 0.7F ? vec3(0, 1, 0) : vec3(1, 0, 0);
  const vec3 tangent = glm::normalize(glm::cross(n, helper));
  return disk.x * tangent + disk.y * glm::cross(n, tangent) + std::sqrt(std::max(0.0F, 1 - square.x)) * n;
}

struct Hit {
  vec3 point;
  vec3 geometric_normal;  // unit, towards where the ray came from
  const Surface* surface = nullptr;
  const Material* material = nullptr;
  [[nodiscard]] vec3 start() const { return point + kOffset * geometric_normal; }
};

RTCRay make_ray(const vec3& from, const vec3& step, float reach) {
  RTCRay ray{};
  ray.org_x = from.x;
  ray.org_y = from.y;
  ray.org_z = from.z;
  ray.dir_x = step.x;
  ray.dir_y = step.y;
  ray.dir_z = step.z;
  ray.tfar = reach;
  ray.mask = ~0U;
  return ray;
}

// Surfaces that are traced together.
class Layer {
 public:
  Layer(RTCDevice device, const Tessellation& geometry, const std::vector<Material>& materials)
      : geometry_(geometry), materials_(materials), rtc_scene_(make_rtc_scene(device, geometry.mesh)) {}

  // False where nothing is hit; else `reach` becomes the distance in steps.
  bool intersect(const vec3& from, const vec3& step, float& reach, Hit& hit) const {
    RTCRayHit query{};
    query.ray = make_ray(from, step, reach);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(rtc_scene_.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    reach = query.ray.tfar;
    hit.point = from + reach * step;
    hit.surface = &geometry_.surfaces[geometry_.surface_of_face[query.hit.primID]];
    hit.material = &materials_[hit.surface->material];
    const vec3 n = glm::normalize(vec3(query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z));
    hit.geometric_normal = glm::dot(n, step) > 0 ? -n : n;
    return true;
  }

  [[nodiscard]] bool free(const vec3& from, const vec3& step, float reach) const {  // no surface in (0, reach) steps
    RTCRay ray = make_ray(from, step, reach);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(rtc_scene_.get(), &context, &ray);
    return ray.tfar >= 0;
  }

 private:
  const Tessellation& geometry_;
  const std::vector<Material>& materials_;
  RtcScene rtc_scene_;
};

// The scene's surfaces and those of a visitor, if there is one. Two layers rather than one mesh: where the visitor
// plays no part, every ray hits what it hits without.
class Surfaces {
 public:
  Surfaces(const Layer& scene, const Layer* visitor) : scene_(scene), visitor_(visitor) {}

  bool intersect(const vec3& from, const vec3& step, float& reach, Hit& hit) const {
    const bool scene_hit = scene_.intersect(from, step, reach, hit);
    const bool visitor_hit = meets_visitor(from, step, reach, hit);
    return scene_hit || visitor_hit;
  }
  bool meets_visitor(const vec3& from, const vec3& step, float& reach, Hit& hit) const {
    return visitor_ != nullptr && visitor_->intersect(from, step, reach, hit);
  }
  [[nodiscard]] bool free(const vec3& from, const vec3& step, float reach) const {
    return scene_.free(from, step, reach) && (visitor_ == nullptr || visitor_->free(from, step, reach));
  }

 private:
  const Layer& scene_;
  const Layer* visitor_;
};

// The light along the paths of one photograph.
class Paths {
 public:
  Paths(const Scene& scene, const Surfaces& surfaces) : scene_(scene), surfaces_(surfaces) {}

  [[nodiscard]] vec3 pixel(const Camera& camera, std::uint32_t x, std::uint32_t y, std::uint32_t samples,
                           const PixelSamples& random) const {
    const vec3 center(camera.center());
    vec3 sum(0.0F);
    for (std::uint32_t sample = 0; sample < samples; ++sample) {
      const glm::dvec2 place = glm::dvec2(x, y) + glm::dvec2(random.point(kPixel, sample));
      const vec3 direction(glm::normalize(camera.ray(place)));
      sum += glm::min(seen(center, direction, random, sample), vec3(kBrightest));
    }
    return sum / static_cast<float>(samples);
  }

 private:
  // Radiance along a ray of the camera.
  [[nodiscard]] vec3 seen(const vec3& from, const vec3& direction, const PixelSamples& random,
                          std::uint32_t sample) const {
    Hit hit;
    float reach = std::numeric_limits<float>::infinity();
    if (!surfaces_.intersect(from, direction, reach, hit)) return vec3(0.0F);
    const Material& material = *hit.material;
    const vec3 color = pattern_color(material, coordinates(*hit.surface, hit.point), hit.surface->size);
    if (material.emission > 0) return material.emission * color;
    const vec3 n = facing_normal(hit, direction);
    const float schlick = std::pow(1 - std::abs(glm::dot(n, direction)), 5.0F);
    if (material.metal) {
      return glm::mix(color, vec3(1.0F), schlick) * reflected(hit, n, direction, material.roughness, random, sample);
    }
    const float share = openness(hit, n, random.point(kOcclusion, sample));
    const vec3 light = color * (direct(hit, n, random, kFirstLight, sample) + share * ambient(n));
    if (material.gloss <= 0) return light;
    const float fresnel = material.gloss + (1 - material.gloss) * schlick;
    return glm::mix(light, reflected(hit, n, direction, material.roughness, random, sample), fresnel);
  }

  [[nodiscard]] vec3 reflected(const Hit& hit, const vec3& n, const vec3& direction, float roughness,
                               const PixelSamples& random, std::uint32_t sample) const {
    const vec3 mirror = glm::reflect(direction, n);
    const vec2 disk = roughness * in_disk(random.point(kLobe, sample));
    const vec3 helper = std::abs(mirror.z) > 0.7F ? vec3(1, 0, 0) : vec3(0, 0, 1);
    const vec3 across = glm::normalize(glm::cross(mirror, helper));
    const vec3 step = glm::normalize(mirror + disk.x * across + disk.y * glm::cross(mirror, across));
    if (glm::dot(step, hit.geometric_normal) <= 0) return ambient(n);  // the lobe reaches below the surface
    Hit other;
    float reach = std::numeric_limits<float>::infinity();
    if (!surfaces_.intersect(hit.start(), step, reach, other)) return vec3(0.0F);
    const Material& material = *other.material;
    const vec3 color = pattern_color(material, coordinates(*other.surface, other.point), other.surface->size);
    if (material.emission > 0) return glm::min(material.emission * color, vec3(kBrightest));
    const vec3 other_normal = facing_normal(other, step);
    if (material.metal) return color * ambient(other_normal);  // one bounce: no mirror in the mirror
    return color *
           (direct(other, other_normal, random, kFirstLight + scene_.lights.size(), sample) + ambient(other_normal));
  }

  static vec3 facing_normal(const Hit& hit, const vec3& direction) {
    const vec3 n = normal(*hit.surface, hit.point);
    return glm::dot(n, direction) > 0 ? -n : n;
  }

  [[nodiscard]] vec3 ambient(const vec3& n) const {
    return glm::mix(scene_.ambient_below, scene_.ambient_above, 0.5F + 0.5F * n.z);
  }

  // The share of ambient light that arrives: 1 in the open, less where surfaces are near.
  [[nodiscard]] float openness(const Hit& hit, const vec3& n, const vec2& square) const {
    Hit near;
    float reach = kOcclusionReach;
    if (!surfaces_.intersect(hit.start(), around(n, square), reach, near)) return 1;
    const float share = reach / kOcclusionReach;
    return 0.25F + 0.75F * share * (2 - share);
  }

  // Irradiance of the lights over pi: what a white diffuse surface would send out.
  [[nodiscard]] vec3 direct(const Hit& hit, const vec3& n, const PixelSamples& random, std::size_t first_purpose,
                            std::uint32_t sample) const {
    vec3 sum(0.0F);
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
      const AreaLight& light = scene_.lights[i];
      const vec2& place = random.point(first_purpose + i, sample);
      const vec3 from = hit.start();
      const vec3 step = light.corner + place.x * light.edge_u + place.y * light.edge_v - from;
      const float arriving = glm::dot(n, step);
      const float leaving = -glm::dot(glm::cross(light.edge_u, light.edge_v), step);  // times the light's area
      if (arriving <= 0 || leaving <= 0 || glm::dot(hit.geometric_normal, step) <= 0) continue;
      const float squared = std::max(glm::dot(step, step), kNearest * kNearest);
      const vec3 part = light.radiance * (arriving * leaving / (std::numbers::pi_v<float> * squared * squared));
      if (std::max({part.x, part.y, part.z}) > kNegligible && surfaces_.free(from, step, 0.999F)) sum += part;
    }
    return sum;
  }

  const Scene& scene_;
  Surfaces surfaces_;
};

// The part of the light that the lens lets through to a pixel, times the gains.
vec3 transmitted(const Exposure& exposure, const Camera& camera, std::uint32_t x, std::uint32_t y) {
  const glm::dvec2 off = glm::dvec2(x + 0.5, y + 0.5) - glm::dvec2(camera.cx, camera.cy);
  const double squared = 4 * glm::dot(off, off) / (std::pow(camera.width, 2) + std::pow(camera.height, 2));
  return exposure.gain * static_cast<float>(std::max(0.0, 1 - exposure.vignetting * squared));
}

}  // namespace

struct Visitor::Body {
  Body(RTCDevice device, std::span<const Solid> solids, std::vector<Material> given)
      : geometry(tessellate(solids, kCoarse)), materials(std::move(given)), layer(device, geometry, materials) {}

  static constexpr double kCoarse = 100;  // no edge is cut
  Tessellation geometry;
  std::vector<Material> materials;
  Layer layer;
};

class Tracer::Implementation {
 public:
  explicit Implementation(const Scene& scene)
      : scene_(scene),
        device_(rtcNewDevice(nullptr)),
        layer_(checked(device_.get()), scene.geometry, scene.materials) {}

  [[nodiscard]] Surfaces surfaces(const Visitor* visitor) const {
    return {layer_, visitor == nullptr ? nullptr : &visitor->body_->layer};
  }

  [[nodiscard]] std::shared_ptr<const Visitor::Body> body(std::span<const Solid> solids,
                                                          std::vector<Material> materials) const {
    return std::make_shared<Visitor::Body>(device_.get(), solids, std::move(materials));
  }

  [[nodiscard]] Photograph photograph(const Camera& camera, std::uint32_t samples, std::uint64_t seed,
                                      const Exposure& exposure, const Visitor* visitor) const {
    const Paths paths(scene_, surfaces(visitor));
    Photograph photo = black(camera);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, camera.height),
                      [&](const tbb::blocked_range<std::uint32_t>& rows) {
                        PixelSamples random(kFirstLight + 2 * scene_.lights.size(), samples);
                        for (std::uint32_t y = rows.begin(); y < rows.end(); ++y) {
                          for (std::uint32_t x = 0; x < camera.width; ++x) {
                            random.reset(hashed(seed, y, x));
                            const vec3 light = paths.pixel(camera, x, y, samples, random);
                            const vec3 exposed = transmitted(exposure, camera, x, y) * light;
                            std::uint8_t* rgb = &photo.rgb[3 * (std::size_t{y} * camera.width + x)];
                            for (int channel = 0; channel < 3; ++channel)
                              rgb[channel] = srgb_from_linear(exposed[channel]);
                          }
                        }
                      });
    return photo;
  }

  [[nodiscard]] Photograph mask(const Camera& camera, const Visitor& visitor) const {
    const Surfaces both = surfaces(&visitor);
    const Surfaces scene = surfaces(nullptr);
    const vec3 center(camera.center());
    Photograph mask = black(camera);
    tbb::parallel_for(std::uint32_t{0}, camera.height, [&](std::uint32_t y) {
      for (std::uint32_t x = 0; x < camera.width; ++x) {
        const vec3 direction(glm::normalize(camera.ray(glm::dvec2(x + 0.5, y + 0.5))));
        Hit hit;
        float reach = std::numeric_limits<float>::infinity();
        scene.intersect(center, direction, reach, hit);
        if (!both.meets_visitor(center, direction, reach, hit)) continue;
        std::fill_n(&mask.rgb[3 * (std::size_t{y} * camera.width + x)], 3, std::uint8_t{255});
      }
    });
    return mask;
  }

 private:
  static RTCDevice checked(RTCDevice device) {
    if (device == nullptr) throw std::runtime_error("Embree offers no device");
    return device;
  }

  static Photograph black(const Camera& camera) {
    Photograph photo;
    photo.width = camera.width;
    photo.height = camera.height;
    photo.rgb.resize(std::size_t{3} * camera.width * camera.height);
    return photo;
  }

  const Scene& scene_;
  Device device_;
  Layer layer_;
};

Tracer::Tracer(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {}
Tracer::~Tracer() = default;
Tracer::Tracer(Tracer&&) noexcept = default;
Tracer& Tracer::operator=(Tracer&&) noexcept = default;

Photograph Tracer::photograph(const Camera& camera, std::uint32_t samples, std::uint64_t seed, const Exposure& exposure,
                              const Visitor* visitor) const {
  check(camera);
  if (samples == 0) throw std::invalid_argument("tracer: samples is 0, must be at least 1");
  return implementation_->photograph(camera, samples, seed, exposure, visitor);
}

Visitor Tracer::visitor(std::span<const Solid> solids, std::vector<Material> materials) const {
  return Visitor(implementation_->body(solids, std::move(materials)));
}

Photograph Tracer::mask(const Camera& camera, const Visitor& visitor) const {
  check(camera);
  return implementation_->mask(camera, visitor);
}

std::optional<glm::dvec3> Tracer::surface_at(const Camera& camera, const glm::dvec2& position) const {
  Hit hit;
  float reach = std::numeric_limits<float>::infinity();
  const vec3 center(camera.center());
  const vec3 direction(glm::normalize(camera.ray(position)));
  if (!implementation_->surfaces(nullptr).intersect(center, direction, reach, hit)) return std::nullopt;
  return glm::dvec3(hit.point);
}

bool Tracer::sees(const glm::dvec3& from, const glm::dvec3& to, const Visitor* visitor) const {
  return implementation_->surfaces(visitor).free(vec3(from), vec3(to - from), 0.999F);
}

Photograph trace_photograph(const Scene& scene, const Camera& camera, std::uint32_t samples, std::uint64_t seed) {
  return Tracer(scene).photograph(camera, samples, seed);
}

}  // namespace lumatlas::synth
