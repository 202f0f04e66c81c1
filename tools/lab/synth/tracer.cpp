// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel reflectance: Schlick, "An inexpensive BRDF model for physically-based rendering", 1994.
// Two-dimensional Fibonacci lattices with a random shift: Cranley, Patterson, "Randomization of number theoretic
// methods for multiple integration", 1976.
#include "tools/lab/synth/tracer.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "mesh/visibility/embree_scene.h"
#include "tools/lab/synth/random.h"

namespace lumatlas::synth {
namespace {

using glm::vec2;
using glm::vec3;

constexpr float kOffset = 2e-4F;  // rays start this far off the surface, scene units: above float noise at 10 units
constexpr float kBrightest =
    2.0F;  // the most light of one path: lamps stay white, their edges and reflections stay smooth
constexpr float kNearestLight = 0.6F;  // lights are no nearer than this, scene units: else their frames are all noise
constexpr float kNegligible = 1e-3F;   // a light's part of white that needs no shadow ray
constexpr std::uint64_t kSensor = 0x6e6f697365;  // use of the sensor's random numbers

EmbreeScene make_scene(RTCDevice device, const Mesh& mesh) {
  // Built by one thread: the order of a leaf's triangles decides which of two is hit on their common edge.
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  return make_embree_scene(device, mesh, RTC_BUILD_QUALITY_HIGH);
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
  static vec2 wrapped(const vec2& v) { return {v.x < 1 ? v.x : v.x - 1, v.y < 1 ? v.y : v.y - 1}; }  // takes [0, 2)

  std::uint32_t count_;
  std::vector<vec2> lattice_;  // Fibonacci lattice
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

// Paths of one pixel that are traced together: rays that are near each other share most of the way.
constexpr std::uint32_t kLanes = EmbreePacket::kRays;

struct Bundle {
  struct Ray {
    std::uint32_t lane;
    vec3 from, step;
    float reach;  // steps
  };
  std::array<Ray, kLanes> rays;
  std::uint32_t count = 0;  // number of rays

  void add(std::uint32_t lane, const vec3& from, const vec3& step, float reach) {
    rays[count++] = {lane, from, step, reach};
  }
};

EmbreePacket packet_of(const Bundle& bundle) {
  EmbreePacket packet;
  for (std::uint32_t i = 0; i < bundle.count; ++i) {
    packet.set(i, bundle.rays[i].from, bundle.rays[i].step, bundle.rays[i].reach);
  }
  return packet;
}

// Surfaces that are traced together.
class Layer {
 public:
  Layer(RTCDevice device, const Tessellation& geometry, const std::vector<Material>& materials)
      : geometry_(geometry), materials_(materials), rtc_scene_(make_scene(device, geometry.mesh)) {}

  // Returns false where nothing is hit; else `reach` becomes the distance in steps.
  bool intersect(const vec3& from, const vec3& step, float& reach, Hit& hit) const {
    RTCRayHit query{};
    query.ray = make_ray(from, step, reach);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(rtc_scene_.get(), &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
    reach = query.ray.tfar;
    hit = hit_at(query.hit.primID, from + reach * step, {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, step);
    return true;
  }

  // Traces all rays of a bundle as the function above traces one: hits are by lane, and those of rays that hit nothing
  // are left as they are.
  void intersect(Bundle& bundle, std::array<Hit, kLanes>& hits) const {
    EmbreePacket packet = packet_of(bundle);
    packet.intersect(rtc_scene_.get());
    const RTCRayHit16& query = packet.hits;
    for (std::uint32_t i = 0; i < bundle.count; ++i) {
      if (query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID) continue;
      Bundle::Ray& ray = bundle.rays[i];
      ray.reach = query.ray.tfar[i];
      hits[ray.lane] = hit_at(query.hit.primID[i], ray.from + ray.reach * ray.step,
                              {query.hit.Ng_x[i], query.hit.Ng_y[i], query.hit.Ng_z[i]}, ray.step);
    }
  }

  // Leaves in the bundle the rays that meet no surface.
  void keep_free(Bundle& bundle) const {
    EmbreePacket packet = packet_of(bundle);
    packet.occlude(rtc_scene_.get());
    std::uint32_t kept = 0;
    for (std::uint32_t i = 0; i < bundle.count; ++i) {
      if (packet.hits.ray.tfar[i] >= 0) bundle.rays[kept++] = bundle.rays[i];
    }
    bundle.count = kept;
  }

  [[nodiscard]] bool free(const vec3& from, const vec3& step, float reach) const {  // no surface in (0, reach) steps
    RTCRay ray = make_ray(from, step, reach);
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(rtc_scene_.get(), &context, &ray);
    return ray.tfar >= 0;
  }

 private:
  [[nodiscard]] Hit hit_at(std::uint32_t face, const vec3& point, const vec3& across, const vec3& step) const {
    const Surface& surface = geometry_.surfaces[geometry_.surface_of_face[face]];
    const vec3 n = glm::normalize(across);
    return {point, glm::dot(n, step) > 0 ? -n : n, &surface, &materials_[surface.material]};
  }

  const Tessellation& geometry_;
  const std::vector<Material>& materials_;
  EmbreeScene rtc_scene_;
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
  void intersect(Bundle& bundle, std::array<Hit, kLanes>& hits) const {
    if (bundle.count == 0) return;
    scene_.intersect(bundle, hits);
    if (visitor_ != nullptr) visitor_->intersect(bundle, hits);
  }
  void keep_free(Bundle& bundle) const {
    if (bundle.count > 0) scene_.keep_free(bundle);
    if (bundle.count > 0 && visitor_ != nullptr) visitor_->keep_free(bundle);
  }
  [[nodiscard]] bool free(const vec3& from, const vec3& step, float reach) const {
    return scene_.free(from, step, reach) && (visitor_ == nullptr || visitor_->free(from, step, reach));
  }

 private:
  const Layer& scene_;
  const Layer* visitor_;
};

// The surface that a path of the camera or of a reflection has reached.
struct PathEnd {
  Hit hit;  // no surface: nothing
  vec3 direction;
  vec3 color;
  vec3 n;  // unit, of the smooth shape, towards where the ray came from
  vec3 light{0.0F};
};
using PathEnds = std::array<PathEnd, kLanes>;

// The light along the paths of one photograph, `kLanes` paths of a pixel at a time.
class Paths {
 public:
  Paths(const Scene& scene, const Surfaces& surfaces, const Motion& motion)
      : scene_(scene), surfaces_(surfaces), motion_(motion), moves_(motion != Motion{}) {}

  // The moment's is the last, so that it changes no other random number.
  [[nodiscard]] std::size_t purposes() const { return moment() + (moves_ ? 1 : 0); }

  [[nodiscard]] vec3 pixel(const Camera& camera, std::uint32_t x, std::uint32_t y, std::uint32_t samples,
                           const PixelSamples& random) const {
    vec3 sum(0.0F);
    for (std::uint32_t first = 0; first < samples; first += kLanes) {
      const std::uint32_t count = std::min(kLanes, samples - first);
      Bundle rays;
      for (std::uint32_t lane = 0; lane < count; ++lane) {
        const glm::dvec2 place = glm::dvec2(x, y) + glm::dvec2(random.point(kPixel, first + lane));
        const Camera eye = moves_ ? moved(camera, (random.point(moment(), first + lane).x - 0.5) * motion_) : camera;
        rays.add(lane, vec3(eye.center()), vec3(glm::normalize(eye.ray(place))),
                 std::numeric_limits<float>::infinity());
      }
      const PathEnds seen = light_along(rays, random, first);
      for (std::uint32_t lane = 0; lane < count; ++lane) sum += glm::min(seen[lane].light, vec3(kBrightest));
    }
    return sum / static_cast<float>(samples);
  }

 private:
  [[nodiscard]] std::size_t moment() const { return kFirstLight + 2 * scene_.lights.size(); }

  // Returns the ends of a bundle's rays; `light` is that of surfaces that shine by themselves.
  [[nodiscard]] PathEnds arrived(Bundle& rays) const {
    std::array<Hit, kLanes> hits;
    surfaces_.intersect(rays, hits);
    PathEnds places;
    for (std::uint32_t i = 0; i < rays.count; ++i) {
      const Bundle::Ray& ray = rays.rays[i];
      PathEnd& place = places[ray.lane];
      place.hit = hits[ray.lane];
      if (place.hit.surface == nullptr) {
        if (scene_.sky) place.light = sky_color(*scene_.sky, ray.step);
        continue;
      }
      const Surface& surface = *place.hit.surface;
      place.direction = ray.step;
      place.color = pattern_color(*place.hit.material, coordinates(surface, place.hit.point), surface.size);
      place.n = normal(surface, place.hit.point);
      if (glm::dot(place.n, ray.step) > 0) place.n = -place.n;
      if (place.hit.material->emission > 0) place.light = place.hit.material->emission * place.color;
    }
    return places;
  }

  static bool reflects(const PathEnd& place) {
    return place.hit.surface != nullptr && place.hit.material->emission <= 0;
  }
  static bool is_diffuse(const PathEnd& place) { return reflects(place) && !place.hit.material->metal; }

  // Radiance along rays of the camera.
  [[nodiscard]] PathEnds light_along(Bundle& rays, const PixelSamples& random, std::uint32_t first) const {
    PathEnds places = arrived(rays);
    add_diffuse(places, random, first);
    const std::array<vec3, kLanes> mirrored = reflections(places, random, first);
    for (PathEnd& place : places) {
      if (!reflects(place)) continue;
      const Material& material = *place.hit.material;
      const vec3& mirror = mirrored[static_cast<std::size_t>(&place - places.data())];
      const float schlick = std::pow(1 - std::abs(glm::dot(place.n, place.direction)), 5.0F);
      if (material.metal) {
        place.light = glm::mix(place.color, vec3(1.0F), schlick) * mirror;
      } else if (material.gloss > 0) {
        place.light = glm::mix(place.light, mirror, material.gloss + (1 - material.gloss) * schlick);
      }
    }
    return places;
  }

  void add_diffuse(PathEnds& places, const PixelSamples& random, std::uint32_t first) const {
    const std::array<vec3, kLanes> irradiance = direct(places, random, kFirstLight, first);
    const std::array<float, kLanes> share = openness(places, random, first);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      PathEnd& place = places[lane];
      if (is_diffuse(place)) place.light = place.color * (irradiance[lane] + share[lane] * ambient(place.n));
    }
  }

  // Returns the light that glossy and metal surfaces mirror.
  [[nodiscard]] std::array<vec3, kLanes> reflections(const PathEnds& places, const PixelSamples& random,
                                                     std::uint32_t first) const {
    std::array<vec3, kLanes> light{};
    Bundle rays;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const PathEnd& place = places[lane];
      if (!reflects(place) || (!place.hit.material->metal && place.hit.material->gloss <= 0)) continue;
      const vec3 step = in_lobe(place, random.point(kLobe, first + lane));
      if (glm::dot(step, place.hit.geometric_normal) > 0) {
        rays.add(lane, place.hit.start(), step, std::numeric_limits<float>::infinity());
      } else {
        light[lane] = ambient(place.n);  // the lobe reaches below the surface
      }
    }
    if (rays.count == 0) return light;
    const PathEnds others = arrived(rays);
    const std::array<vec3, kLanes> irradiance = direct(others, random, kFirstLight + scene_.lights.size(), first);
    for (std::uint32_t i = 0; i < rays.count; ++i) {
      const std::uint32_t lane = rays.rays[i].lane;
      const PathEnd& other = others[lane];
      light[lane] = glm::min(other.light, vec3(kBrightest));
      if (!reflects(other)) continue;
      light[lane] = other.color * (irradiance[lane] + ambient(other.n));  // one bounce: no mirror in the mirror
    }
    return light;
  }

  static vec3 in_lobe(const PathEnd& place, const vec2& square) {
    const vec3 mirror = glm::reflect(place.direction, place.n);
    const vec2 disk = place.hit.material->roughness * in_disk(square);
    const vec3 helper = std::abs(mirror.z) > 0.7F ? vec3(1, 0, 0) : vec3(0, 0, 1);
    const vec3 across = glm::normalize(glm::cross(mirror, helper));
    return glm::normalize(mirror + disk.x * across + disk.y * glm::cross(mirror, across));
  }

  [[nodiscard]] vec3 ambient(const vec3& n) const {
    return glm::mix(scene_.ambient_below, scene_.ambient_above, 0.5F + 0.5F * n.z);
  }

  // The share of ambient light that arrives: 1 in the open, less where surfaces are near.
  [[nodiscard]] std::array<float, kLanes> openness(const PathEnds& places, const PixelSamples& random,
                                                   std::uint32_t first) const {
    std::array<float, kLanes> shares;
    shares.fill(1);
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {  // one by one: these rays go all ways
      if (!is_diffuse(places[lane])) continue;
      Hit near;
      float reach = scene_.occlusion_reach;
      const vec3 step = around(places[lane].n, random.point(kOcclusion, first + lane));
      if (!surfaces_.intersect(places[lane].hit.start(), step, reach, near)) continue;
      const float share = reach / scene_.occlusion_reach;
      shares[lane] = 0.25F + 0.75F * share * (2 - share);
    }
    return shares;
  }

  // Irradiance of the lights over pi: what a white diffuse surface would send out. 0 where there is none.
  [[nodiscard]] std::array<vec3, kLanes> direct(const PathEnds& places, const PixelSamples& random,
                                                std::size_t first_purpose, std::uint32_t first) const {
    std::array<vec3, kLanes> sums{};
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
      std::array<vec3, kLanes> parts;
      Bundle rays;
      for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
        if (!is_diffuse(places[lane])) continue;
        const AreaLight& light = scene_.lights[i];
        const vec2& place = random.point(first_purpose + i, first + lane);
        const vec3 from = places[lane].hit.start();
        const vec3 step = light.corner + place.x * light.edge_u + place.y * light.edge_v - from;
        parts[lane] = arriving(light, places[lane], step);
        if (std::max({parts[lane].x, parts[lane].y, parts[lane].z}) > kNegligible) rays.add(lane, from, step, 0.999F);
      }
      surfaces_.keep_free(rays);
      for (std::uint32_t k = 0; k < rays.count; ++k) sums[rays.rays[k].lane] += parts[rays.rays[k].lane];
    }
    return sums;
  }

  // The share of a light that `step` leads to, if nothing is in the way.
  static vec3 arriving(const AreaLight& light, const PathEnd& place, const vec3& step) {
    const float arriving = glm::dot(place.n, step);
    const float leaving = -glm::dot(glm::cross(light.edge_u, light.edge_v), step);  // times the light's area
    if (arriving <= 0 || leaving <= 0 || glm::dot(place.hit.geometric_normal, step) <= 0) return vec3(0.0F);
    const float squared = std::max(glm::dot(step, step), kNearestLight * kNearestLight);
    return light.radiance * (arriving * leaving / (std::numbers::pi_v<float> * squared * squared));
  }

  const Scene& scene_;
  Surfaces surfaces_;
  Motion motion_;
  bool moves_;
};

// The part of the light that the lens lets through to a pixel, times the gains.
vec3 transmitted(const Exposure& exposure, const Camera& camera, std::uint32_t x, std::uint32_t y) {
  const glm::dvec2 off = glm::dvec2(x + 0.5, y + 0.5) - glm::dvec2(camera.cx, camera.cy);
  const double squared = 4 * glm::dot(off, off) / (std::pow(camera.width, 2) + std::pow(camera.height, 2));
  return exposure.gain * static_cast<float>(std::max(0.0, 1 - exposure.vignetting * squared));
}

// Normal distributions stand for the counts of photons and electrons: they are many.
vec3 with_noise(const vec3& light, double noise, Random random) {
  if (noise == 0) return light;
  constexpr double kMidGrey = 0.21586;  // linear light of sRGB 128
  constexpr double kSlope =
      1.055 / 2.4 * 2.4457;            // slope of sRGB over linear light there; kMidGrey^(1 / 2.4 - 1) = 2.4457
  constexpr double kReadShare = 0.02;  // share of the variance at mid grey that is left in the dark
  vec3 noisy;
  for (int channel = 0; channel < 3; ++channel) {
    const double variance = kReadShare + (1 - kReadShare) * light[channel] / kMidGrey;  // relative to that at mid grey
    const double deviation = noise / (255 * kSlope) * std::sqrt(variance);
    noisy[channel] = light[channel] + static_cast<float>(deviation * gaussian(random));
  }
  return noisy;
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
      : scene_(scene), device_(make_embree_device()), layer_(device_.get(), scene.geometry, scene.materials) {}

  [[nodiscard]] Surfaces surfaces(const Visitor* visitor) const {
    return {layer_, visitor == nullptr ? nullptr : &visitor->body_->layer};
  }

  [[nodiscard]] std::shared_ptr<const Visitor::Body> body(std::span<const Solid> solids,
                                                          std::vector<Material> materials) const {
    return std::make_shared<Visitor::Body>(device_.get(), solids, std::move(materials));
  }

  [[nodiscard]] Photograph photograph(const Camera& camera, std::uint32_t samples, std::uint64_t seed,
                                      const Exposure& exposure, const Visitor* visitor) const {
    const Paths paths(scene_, surfaces(visitor), exposure.motion);
    Photograph photo = black(camera);
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, camera.height),
                      [&](const tbb::blocked_range<std::uint32_t>& rows) {
                        PixelSamples random(paths.purposes(), samples);
                        for (std::uint32_t y = rows.begin(); y < rows.end(); ++y) {
                          for (std::uint32_t x = 0; x < camera.width; ++x) {
                            random.reset(hashed(seed, y, x));
                            const vec3 light = paths.pixel(camera, x, y, samples, random);
                            const vec3 exposed = with_noise(transmitted(exposure, camera, x, y) * light, exposure.noise,
                                                            Random(hashed(seed, kSensor, y, x)));
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
  static Photograph black(const Camera& camera) {
    Photograph photo;
    photo.width = camera.width;
    photo.height = camera.height;
    photo.rgb.resize(std::size_t{3} * camera.width * camera.height);
    return photo;
  }

  const Scene& scene_;
  EmbreeDevice device_;
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
  const std::optional<Sighting> seen = sighting_at(camera, position);
  if (!seen) return std::nullopt;
  return glm::dvec3(seen->point);
}

std::optional<Sighting> Tracer::sighting_at(const Camera& camera, const glm::dvec2& position) const {
  Hit hit;
  float reach = std::numeric_limits<float>::infinity();
  const vec3 center(camera.center());
  const vec3 direction(glm::normalize(camera.ray(position)));
  if (!implementation_->surfaces(nullptr).intersect(center, direction, reach, hit)) return std::nullopt;
  return Sighting{hit.point, hit.geometric_normal, hit.surface, hit.material};
}

bool Tracer::sees(const glm::dvec3& from, const glm::dvec3& to, const Visitor* visitor) const {
  return implementation_->surfaces(visitor).free(vec3(from), vec3(to - from), 0.999F);
}

}  // namespace lumatlas::synth
