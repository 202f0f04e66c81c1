// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/patch_match.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

namespace lumatlas {
namespace {

constexpr int kCoarsestRounds = 6, kFinerRounds = 2;
constexpr float kConsistencyWeight = 0.1F, kConsistencyLimitPx = 3;
constexpr float kSameDepthPx = 0.1F;  // planes that move a patch by less are one
constexpr float kFinerMovePx = 2;     // that a plane is disturbed by at first, at all but the coarsest level
constexpr float kSteepest = 6;        // tangent of the largest angle between a ray and a plane's normal
constexpr int kPatchRadius = 5;       // pixels

// Regions that good planes are taken from: four wedges close by and four lines that reach farther, all of the other
// colour.
constexpr std::size_t kRegions = 8;

const std::array<std::vector<glm::ivec2>, kRegions>& regions() {
  static const std::array<std::vector<glm::ivec2>, kRegions> all = [] {
    std::array<std::vector<glm::ivec2>, kRegions> result;
    const std::array<glm::ivec2, 4> ways{glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)};
    for (std::size_t i = 0; i < ways.size(); ++i) {
      const glm::ivec2 along = ways[i], across(along.y, along.x);
      result[i].push_back(along);
      for (int step = 1; step <= 3; ++step) {
        result[i].push_back((step + 1) * along + step * across);
        result[i].push_back((step + 1) * along - step * across);
      }
      for (int step = 3; step <= 23; step += 2) result[ways.size() + i].push_back(step * along);
    }
    return result;
  }();
  return all;
}

// Numbers by chance that depend on nothing but where and when they are asked for.
class Chance {
 public:
  Chance(std::size_t pixel, std::uint32_t level, int round)
      : state_((std::uint64_t{pixel} << 16U) ^ (std::uint64_t{level} << 8U) ^ static_cast<std::uint64_t>(round)) {}

  // In [-1, 1).
  float next() {
    // splitmix64 (Steele et al., "Fast splittable pseudorandom number generators", 2014).
    state_ += 0x9E3779B97F4A7C15U;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
    return static_cast<float>((z ^ (z >> 31U)) >> 40U) / 8388608.0F - 1;
  }

 private:
  std::uint64_t state_;
};

// The planes of one level.
class LevelMatcher {
 public:
  LevelMatcher(const MatchedViews& views, std::size_t level, const InverseDepthRange& range, bool coarsest)
      : reference_((*views.reference)[level]),
        range_(range),
        level_(static_cast<std::uint32_t>(level)),
        coarsest_(coarsest),
        focal_(static_cast<float>(reference_.camera.fx)) {
    for (const LumaPyramid* other : views.others) {
      const LumaImage& image = (*other)[std::min(level, other->size() - 1)];
      others_.push_back({&image, pixel_transfer(reference_.camera, image.camera),
                         pixel_transfer(image.camera, reference_.camera), nullptr});
    }
  }

  void compare_with(std::span<const PlaneMap* const> planes) {
    for (std::size_t i = 0; i < others_.size(); ++i) others_[i].planes = planes[i];
  }

  [[nodiscard]] PlaneMap by_chance() const {
    PlaneMap map = empty();
    for (std::size_t i = 0; i < map.planes.size(); ++i) {
      if (!reference_.is_valid(i)) continue;
      Chance chance(i, level_, -1);
      const float w = range_.least + (range_.most - range_.least) * 0.5F * (1 + chance.next());
      map.planes[i] = {w, w / focal_ * 0.5F * chance.next(), w / focal_ * 0.5F * chance.next()};
    }
    return map;
  }

  // Enlarges the map of a level of half the size.
  [[nodiscard]] PlaneMap enlarged(const PlaneMap& coarse) const {
    PlaneMap map = empty();
    const auto from_x = static_cast<float>(coarse.width) / static_cast<float>(map.width);
    const auto from_y = static_cast<float>(coarse.height) / static_cast<float>(map.height);
    for (std::uint32_t y = 0; y < map.height; ++y) {
      for (std::uint32_t x = 0; x < map.width; ++x) {
        const float at_x = (static_cast<float>(x) + 0.5F) * from_x, at_y = (static_cast<float>(y) + 0.5F) * from_y;
        const auto column = std::min(coarse.width - 1, static_cast<std::uint32_t>(at_x));
        const auto row = std::min(coarse.height - 1, static_cast<std::uint32_t>(at_y));
        SlantedPlane plane = coarse.planes[std::size_t{row} * coarse.width + column];
        const std::size_t to = std::size_t{y} * map.width + x;
        if (!reference_.is_valid(to) || !(plane.w > 0)) continue;
        plane = plane.moved(at_x - static_cast<float>(column) - 0.5F, at_y - static_cast<float>(row) - 0.5F);
        map.planes[to] = {std::clamp(plane.w, range_.least, range_.most), plane.w_u * from_x, plane.w_v * from_y};
      }
    }
    return map;
  }

  void plant(std::span<const DepthSeed> seeds, PlaneMap& map, bool overwrite) const {
    for (const DepthSeed& seed : seeds) {
      const auto x = static_cast<std::uint32_t>(seed.place.x * static_cast<float>(map.width));
      const auto y = static_cast<std::uint32_t>(seed.place.y * static_cast<float>(map.height));
      if (x >= map.width || y >= map.height || !allows({seed.w, 0, 0})) continue;
      const std::size_t at = std::size_t{y} * map.width + x;
      if (!reference_.is_valid(at)) continue;
      if (overwrite)
        map.planes[at] = {seed.w, 0, 0};
      else
        improve(at, {static_cast<int>(x), static_cast<int>(y)}, {seed.w, 0, 0}, map);
    }
  }

  void set_costs(PlaneMap& map) const {
    for_each_row(map, [&](int y) {
      for (int x = 0; x < static_cast<int>(map.width); ++x) {
        const std::size_t at = index(x, y);
        if (!reference_.is_valid(at)) continue;
        // A pixel of which a coarser level saw nothing starts anywhere.
        if (!(map.planes[at].w > 0)) map.planes[at].w = 0.5F * (range_.least + range_.most);
        map.costs[at] = cost({x, y}, map.planes[at], reference_patch(reference_, {x, y}));
      }
    });
  }

  void run(int rounds, PlaneMap& map) const {
    for (int round = 0; round < rounds; ++round) {
      for (int colour = 0; colour < 2; ++colour) {
        for_each_row(map, [&](int y) {
          for (int x = (y + colour) & 1; x < static_cast<int>(map.width); x += 2) {
            if (reference_.is_valid(index(x, y))) visit({x, y}, round, map);
          }
        });
      }
    }
  }

 private:
  struct Other {
    const LumaImage* image;
    PixelTransfer there, back;
    const PlaneMap* planes;  // none: not compared
  };

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * reference_.camera.width + static_cast<std::size_t>(x);
  }

  [[nodiscard]] PlaneMap empty() const {
    const std::size_t pixels = std::size_t{reference_.camera.width} * reference_.camera.height;
    return {reference_.camera.width, reference_.camera.height, std::vector<SlantedPlane>(pixels),
            std::vector<float>(pixels, kLargestPatchCost)};
  }

  template <typename Row>
  static void for_each_row(const PlaneMap& map, const Row& row) {
    tbb::parallel_for(0, static_cast<int>(map.height), row);
  }

  [[nodiscard]] bool allows(const SlantedPlane& plane) const {
    if (!(plane.w > 0 && plane.w >= range_.least && plane.w <= range_.most)) return false;
    const float steepest = kSteepest * plane.w / focal_;
    return std::abs(plane.w_u) <= steepest && std::abs(plane.w_v) <= steepest;
  }

  // The mean of the two cheapest photographs.
  [[nodiscard]] float cost(glm::ivec2 pixel, const SlantedPlane& plane, const ReferencePatch& patch) const {
    float least = std::numeric_limits<float>::infinity(), second = least;
    for (const Other& other : others_) {
      float value = patch_cost(patch, pixel, plane, other.there, *other.image);
      if (other.planes != nullptr) value += inconsistency(pixel, plane.w, other);
      if (value < least) {
        second = least;
        least = value;
      } else if (value < second) {
        second = value;
      }
    }
    return others_.size() == 1 ? least : 0.5F * (least + second);
  }

  [[nodiscard]] static float inconsistency(glm::ivec2 pixel, float w, const Other& other) {
    const float way = way_back_px(glm::vec2(pixel) + 0.5F, w, other.there, other.back, *other.planes);
    return kConsistencyWeight * std::min(way, kConsistencyLimitPx);
  }

  // Returns by how much the inverse depth grows if the pixel moves by one in the photograph that it moves fastest in.
  [[nodiscard]] float step(glm::ivec2 pixel, float w) const {
    float fastest = 0;
    for (const Other& other : others_) {
      const glm::vec3 at = other.there.homogeneous(glm::vec2(pixel) + 0.5F, w);
      if (!(at.z > 0)) continue;
      const glm::vec2 place = glm::vec2(at) / at.z;
      fastest = std::max(fastest, glm::length(glm::vec2(other.there.epipole) - place * other.there.epipole.z) / at.z);
    }
    return fastest > 0 ? 1 / fastest : range_.most - range_.least;
  }

  void improve(std::size_t at, glm::ivec2 pixel, const SlantedPlane& plane, PlaneMap& map) const {
    improve(at, pixel, plane, reference_patch(reference_, pixel), map);
  }
  void improve(std::size_t at, glm::ivec2 pixel, const SlantedPlane& plane, const ReferencePatch& patch,
               PlaneMap& map) const {
    if (!allows(plane)) return;
    const float value = cost(pixel, plane, patch);
    if (!(value < map.costs[at])) return;
    map.costs[at] = value;
    map.planes[at] = plane;
  }

  void visit(glm::ivec2 pixel, int round, PlaneMap& map) const {
    const std::size_t at = index(pixel.x, pixel.y);
    const ReferencePatch patch = reference_patch(reference_, pixel);
    const float px = step(pixel, map.planes[at].w);
    for (const std::vector<glm::ivec2>& region : regions()) spread(at, pixel, region, px, patch, map);
    disturb(at, pixel, round, px, patch, map);
  }

  // Takes the plane of the cheapest pixel of the region if it is better here.
  void spread(std::size_t at, glm::ivec2 pixel, const std::vector<glm::ivec2>& region, float px,
              const ReferencePatch& patch, PlaneMap& map) const {
    float least = kLargestPatchCost;
    glm::ivec2 from(0);
    std::size_t from_at = at;
    for (const glm::ivec2& offset : region) {
      const glm::ivec2 place = pixel + offset;
      if (place.x < 0 || place.y < 0 || place.x >= static_cast<int>(map.width) ||
          place.y >= static_cast<int>(map.height)) {
        continue;
      }
      const std::size_t candidate = index(place.x, place.y);
      if (!(map.costs[candidate] < least)) continue;
      least = map.costs[candidate];
      from = offset;
      from_at = candidate;
    }
    if (from_at == at) return;
    const SlantedPlane plane = map.planes[from_at].moved(static_cast<float>(-from.x), static_cast<float>(-from.y));
    if (!is_same(plane, map.planes[at], px)) improve(at, pixel, plane, patch, map);
  }

  // Returns whether both move the patch alike.
  static bool is_same(const SlantedPlane& a, const SlantedPlane& b, float px) {
    const float slope = std::max(std::abs(a.w_u - b.w_u), std::abs(a.w_v - b.w_v));
    return std::abs(a.w - b.w) + kPatchRadius * slope < kSameDepthPx * px;
  }

  void disturb(std::size_t at, glm::ivec2 pixel, int round, float px, const ReferencePatch& patch,
               PlaneMap& map) const {
    Chance chance(at, level_, round);
    const float shrink = std::ldexp(1.0F, -round);
    const float far = coarsest_ ? (range_.most - range_.least) * shrink : kFinerMovePx * px * shrink;
    SlantedPlane plane = map.planes[at];
    plane.w += far * chance.next();
    improve(at, pixel, plane, patch, map);
    plane = map.planes[at];
    plane.w += 0.5F * px * shrink * chance.next();
    plane.w_u += plane.w / focal_ * shrink * chance.next();
    plane.w_v += plane.w / focal_ * shrink * chance.next();
    improve(at, pixel, plane, patch, map);
    plane = map.planes[at];
    plane.w_u += 0.25F * plane.w / focal_ * shrink * chance.next();
    plane.w_v += 0.25F * plane.w / focal_ * shrink * chance.next();
    improve(at, pixel, plane, patch, map);
  }

  const LumaImage& reference_;
  InverseDepthRange range_;
  std::uint32_t level_;
  bool coarsest_;
  float focal_;
  std::vector<Other> others_;
};

}  // namespace

PlaneMap match_patches(const MatchedViews& views, const InverseDepthRange& range, std::span<const DepthSeed> seeds) {
  const std::size_t coarsest = views.reference->size() - 1;
  PlaneMap map;
  for (std::size_t level = coarsest + 1; level-- > 0;) {
    const bool is_coarsest = level == coarsest;
    const LevelMatcher matcher(views, level, range, is_coarsest);
    map = is_coarsest ? matcher.by_chance() : matcher.enlarged(map);
    if (is_coarsest) matcher.plant(seeds, map, true);
    matcher.set_costs(map);
    if (!is_coarsest) matcher.plant(seeds, map, false);
    matcher.run(is_coarsest ? kCoarsestRounds : kFinerRounds, map);
  }
  return map;
}

PlaneMap match_consistently(const MatchedViews& views, const InverseDepthRange& range, PlaneMap start,
                            std::span<const PlaneMap* const> other_planes) {
  LevelMatcher matcher(views, 0, range, false);
  matcher.compare_with(other_planes);
  matcher.set_costs(start);
  matcher.run(kFinerRounds, start);
  return start;
}

float way_back_px(glm::vec2 pixel, float w, const PixelTransfer& there, const PixelTransfer& back,
                  const PlaneMap& other) {
  constexpr float kNoWay = std::numeric_limits<float>::infinity();
  const glm::vec3 seen = there.homogeneous(pixel, w);
  if (!(seen.z > 0)) return kNoWay;
  const glm::vec2 at = glm::vec2(seen) / seen.z;
  if (!(at.x >= 0 && at.y >= 0 && at.x < static_cast<float>(other.width) && at.y < static_cast<float>(other.height))) {
    return kNoWay;
  }
  const glm::vec2 whole = glm::floor(at);
  const SlantedPlane& plane =
      other.planes[static_cast<std::size_t>(whole.y) * other.width + static_cast<std::size_t>(whole.x)];
  const float other_w = plane.moved(at.x - whole.x - 0.5F, at.y - whole.y - 0.5F).w;
  if (!(plane.w > 0) || !(other_w > 0)) return kNoWay;
  const glm::vec3 returned = back.homogeneous(at, other_w);
  if (!(returned.z > 0)) return kNoWay;
  return glm::distance(pixel, glm::vec2(returned) / returned.z);
}

}  // namespace lumatlas
