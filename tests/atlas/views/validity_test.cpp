// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/views/validity.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>
#include <string>

namespace lumatlas {
namespace {

constexpr float kNoSurface = std::numeric_limits<float>::infinity();

Photograph grey(std::uint32_t width, std::uint32_t height) {
  return {width, height, std::vector<std::uint8_t>(std::size_t{3} * width * height, 128), {}};
}

std::vector<float> flat_depth(const Photograph& photograph, float z) {
  return std::vector<float>(std::size_t{photograph.width} * photograph.height, z);
}

// A step from `left` to `right` between the columns edge - 1 and edge.
std::vector<float> step_depth(const Photograph& photograph, std::uint32_t edge, float left, float right) {
  std::vector<float> depth;
  for (std::uint32_t y = 0; y < photograph.height; ++y) {
    for (std::uint32_t x = 0; x < photograph.width; ++x) depth.push_back(x < edge ? left : right);
  }
  return depth;
}

using Edges = ValidityOptions::Edges;

ValidityOptions without_fade(double depth_edge = 0.05, std::uint32_t radius = 2, Edges edges = Edges::both_sides) {
  return {depth_edge, radius, 0, edges};
}

std::vector<std::uint8_t> row_of(const std::vector<std::uint8_t>& mask, const Photograph& photograph, std::uint32_t y) {
  const auto begin = mask.begin() + static_cast<std::ptrdiff_t>(y) * photograph.width;
  return {begin, begin + static_cast<std::ptrdiff_t>(photograph.width)};
}

constexpr std::span<const std::uint8_t> kAllTrusted;

TEST_CASE("of a depth step the farther side is invalid within its radius, or both sides") {
  const Photograph photograph = grey(12, 5);
  const std::uint32_t radius = GENERATE(0u, 1u, 2u, 3u);
  const Edges edges = GENERATE(Edges::far_side, Edges::both_sides);
  const bool far_on_the_left = GENERATE(false, true);
  CAPTURE(radius, edges, far_on_the_left);
  const std::vector<float> depth = far_on_the_left ? step_depth(photograph, 6, 2, 1) : step_depth(photograph, 6, 1, 2);
  const auto mask = validity_mask(photograph, depth, kAllTrusted, without_fade(0.05, radius, edges));
  for (std::uint32_t y = 0; y < photograph.height; ++y) {
    for (std::uint32_t x = 0; x < photograph.width; ++x) {
      const bool near_step = x >= 6 - radius && x < 6 + radius;
      const bool counts = edges == Edges::both_sides || (x < 6) == far_on_the_left;
      CHECK(mask[y * photograph.width + x] == (near_step && counts ? 0 : 255));
    }
  }
}

TEST_CASE("rims are before a depth edge or nothing, within the radius of edges") {
  const Photograph photograph = grey(12, 5);
  const float behind = GENERATE(2.0f, kNoSurface);
  const std::vector<float> depth = step_depth(photograph, 6, 1, behind);
  const std::uint32_t radius = GENERATE(0u, 1u, 3u);
  CAPTURE(behind, radius);
  const auto rim = rim_pixels(photograph, depth, {0.05, radius, 2, Edges::far_side});
  for (std::uint32_t pixel = 0; pixel < rim.size(); ++pixel) {
    const std::uint32_t x = pixel % 12;
    CHECK(rim[pixel] == (x < 6 && x >= 6 - radius ? 1 : 0));
  }
  CHECK(rim_pixels(photograph, depth, {0.05, radius, 2, Edges::both_sides}).empty());
  CHECK_THROWS_MATCHES(rim_pixels(photograph, std::vector<float>(3, 1.0f), {}), std::invalid_argument,
                       Catch::Message("validity: depth has 3 values, must have one per pixel of the photograph"));
}

TEST_CASE("the search window is a disc") {
  const Photograph photograph = grey(9, 9);
  std::vector<float> depth = flat_depth(photograph, 1);
  depth[4 * 9 + 4] = 2;  // one pixel stands out
  const auto mask = validity_mask(photograph, depth, kAllTrusted, without_fade(0.05, 2));
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      const bool near = (x - 4) * (x - 4) + (y - 4) * (y - 4) <= 4;
      CHECK(mask[static_cast<std::size_t>(9 * y + x)] == (near ? 0 : 255));
    }
  }
}

TEST_CASE("the depth threshold is relative to the nearer of two depths") {
  const Photograph photograph = grey(6, 3);
  const float scale = GENERATE(1e-3f, 1.0f, 1e5f);  // arbitrary units
  const auto is_edge = [&](float left, float right) {
    const auto mask =
        validity_mask(photograph, step_depth(photograph, 3, scale * left, scale * right), kAllTrusted, without_fade());
    return mask[2] == 0;
  };
  CHECK_FALSE(is_edge(100, 104.9f));
  CHECK(is_edge(100, 105.1f));  // 5.1% of the nearer, 4.9% of the farther
  CHECK(is_edge(105.1f, 100));
  CHECK_FALSE(is_edge(104.9f, 100));
}

TEST_CASE("pixels without a surface are invalid, and those near them if both sides of edges are") {
  const Photograph photograph = grey(8, 3);
  const std::vector<float> depth = step_depth(photograph, 4, 1, kNoSurface);
  const auto both = validity_mask(photograph, depth, kAllTrusted, without_fade());
  CHECK(row_of(both, photograph, 1) == std::vector<std::uint8_t>{255, 255, 0, 0, 0, 0, 0, 0});
  const auto far = validity_mask(photograph, depth, kAllTrusted, without_fade(0.05, 2, Edges::far_side));
  CHECK(row_of(far, photograph, 1) == std::vector<std::uint8_t>{255, 255, 255, 255, 0, 0, 0, 0});
  const auto nothing = validity_mask(photograph, flat_depth(photograph, kNoSurface), kAllTrusted, {});
  CHECK(nothing == std::vector<std::uint8_t>(24, 0));
}

TEST_CASE("pixels outside of the lens's image are invalid") {
  Photograph photograph = grey(7, 3);
  photograph.valid.assign(21, 255);
  for (std::uint32_t y = 0; y < 3; ++y) photograph.valid[7 * y] = photograph.valid[7 * y + 6] = 0;
  const auto mask = validity_mask(photograph, flat_depth(photograph, 3), kAllTrusted, without_fade());
  CHECK(row_of(mask, photograph, 1) == std::vector<std::uint8_t>{0, 255, 255, 255, 255, 255, 0});
  const auto faded = validity_mask(photograph, flat_depth(photograph, 3), kAllTrusted, {0.05, 2, 1});
  CHECK(row_of(faded, photograph, 1) == std::vector<std::uint8_t>{0, 1, 255, 255, 255, 1, 0});
}

TEST_CASE("without a fade the image's border is wholly valid") {
  const Photograph photograph = grey(5, 4);
  CHECK(validity_mask(photograph, flat_depth(photograph, 3), kAllTrusted, without_fade()) ==
        std::vector<std::uint8_t>(20, 255));
}

TEST_CASE("the fade rises in equal steps from next to nothing at the image's border") {
  const Photograph photograph = grey(11, 11);
  const auto mask = validity_mask(photograph, flat_depth(photograph, 3), kAllTrusted, {0.05, 2, 4});
  CHECK(row_of(mask, photograph, 5) == std::vector<std::uint8_t>{1, 64, 128, 191, 255, 255, 255, 191, 128, 64, 1});
  CHECK(row_of(mask, photograph, 0) == std::vector<std::uint8_t>(11, 1));
}

TEST_CASE("the farther side fades in beyond the edge's radius, the nearer one is whole up to its rim") {
  const Photograph photograph = grey(24, 20);
  const auto mask = validity_mask(photograph, step_depth(photograph, 10, 1, 2), kAllTrusted, {0.05, 2, 3});
  CHECK(row_of(mask, photograph, 9) == std::vector<std::uint8_t>{1, 85, 170, 255, 255, 255, 255, 255, 255, 255, 0,  0,
                                                                 1, 85, 170, 255, 255, 255, 255, 255, 255, 170, 85, 1});
  CHECK(row_of(mask, photograph, 1)[13] == 85);  // the border's fade, no product of the two
}

TEST_CASE("the fade goes by Euclidean distance") {
  Photograph photograph = grey(31, 31);
  photograph.valid.assign(31 * 31, 255);
  photograph.valid[31 * 15 + 15] = 0;
  const auto mask = validity_mask(photograph, flat_depth(photograph, 3), kAllTrusted, {0.05, 2, 9});
  const auto at = [&](std::size_t dx, std::size_t dy) { return mask[31 * (15 + dy) + 15 + dx]; };
  CHECK(at(3, 4) == at(5, 0));
  CHECK(at(4, 3) == 113);  // 4 of 9
  CHECK(at(2, 2) == std::lround(255 * (std::sqrt(8.0) - 1) / 9));
  for (std::size_t distance = 1; distance <= 6; ++distance) {  // beyond, the image's border is nearer
    CHECK(at(distance, 0) > at(distance - 1, 0));
    CHECK(at(distance, 0) == at(0, distance));
  }
}

TEST_CASE("the printed options are a step, and otherwise the defaults") {
  CHECK(ValidityOptions::printed().fade_px == 0);
  CHECK(ValidityOptions::printed().edge_radius_px == 2);
  CHECK(ValidityOptions::printed().depth_edge == 0.05);
  CHECK(ValidityOptions::printed().edges == Edges::both_sides);
  const Photograph photograph = grey(12, 5);
  for (const std::uint8_t value :
       validity_mask(photograph, step_depth(photograph, 6, 1, 2), kAllTrusted, ValidityOptions::printed())) {
    CHECK((value == 0 || value == 255));
  }
}

// The definition, pixel by pixel.
struct Definition {
  const Photograph& photograph;
  const std::vector<float>& depth;
  const ValidityOptions& options;
  int width = static_cast<int>(photograph.width), height = static_cast<int>(photograph.height);

  [[nodiscard]] std::size_t at(int x, int y) const {
    return static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
  }
  [[nodiscard]] bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  [[nodiscard]] bool in_lens(int x, int y) const {
    return inside(x, y) && (photograph.valid.empty() || photograph.valid[at(x, y)] != 0);
  }
  [[nodiscard]] bool before(float z, float other) const { return other - z > options.depth_edge * z; }

  [[nodiscard]] bool edge_near(int x, int y) const {
    const float z = depth[at(x, y)];
    const int radius = static_cast<int>(options.edge_radius_px);
    for (int v = std::max(0, y - radius); v <= std::min(height - 1, y + radius); ++v) {
      for (int u = std::max(0, x - radius); u <= std::min(width - 1, x + radius); ++u) {
        if ((u - x) * (u - x) + (v - y) * (v - y) > radius * radius) continue;
        if (before(depth[at(u, v)], z)) return true;
        if (options.edges == Edges::both_sides && before(z, depth[at(u, v)])) return true;
      }
    }
    return false;
  }

  // Returns whether a pixel within the radius is behind this one.
  [[nodiscard]] bool at_rim(int x, int y) const {
    const int radius = static_cast<int>(options.edge_radius_px);
    for (int v = std::max(0, y - radius); v <= std::min(height - 1, y + radius); ++v) {
      for (int u = std::max(0, x - radius); u <= std::min(width - 1, x + radius); ++u) {
        const bool in_disc = (u - x) * (u - x) + (v - y) * (v - y) <= radius * radius;
        if (in_disc && before(depth[at(x, y)], depth[at(u, v)])) return true;
      }
    }
    return false;
  }

  // Returns whether the pixel of depth z fades towards this one.
  [[nodiscard]] bool fades(float z, int x, int y) const {
    if (!in_lens(x, y)) return true;
    const bool unusable = !std::isfinite(depth[at(x, y)]) || edge_near(x, y);
    return unusable && (options.edges == Edges::both_sides || !before(z, depth[at(x, y)]));
  }

  [[nodiscard]] std::uint8_t value(int x, int y) const {
    const float z = depth[at(x, y)];
    if (!std::isfinite(z)) return 0;
    const int reach = static_cast<int>(options.fade_px) + 1;
    double nearest = reach;
    for (int v = y - reach; v <= y + reach; ++v) {
      for (int u = x - reach; u <= x + reach; ++u) {
        if (fades(z, u, v)) nearest = std::min(nearest, std::hypot(u - x, v - y));
      }
    }
    if (nearest == 0) return 0;
    if (options.fade_px == 0) return 255;
    return static_cast<std::uint8_t>(std::clamp(std::round(255 * (nearest - 1) / options.fade_px), 1.0, 255.0));
  }
};

// `value` of each pixel, in rows.
std::vector<std::uint8_t> of_each_pixel(const Photograph& photograph,
                                        const std::function<std::uint8_t(int x, int y)>& value) {
  std::vector<std::uint8_t> values;
  for (int y = 0; y < static_cast<int>(photograph.height); ++y) {
    for (int x = 0; x < static_cast<int>(photograph.width); ++x) values.push_back(value(x, y));
  }
  return values;
}

TEST_CASE("masks and rims of random depth images are those of the definition") {
  const unsigned seed = GENERATE(range(1u, 25u));
  std::mt19937 random(seed);
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  Photograph photograph = grey(1 + below(27), 1 + below(19));
  std::vector<float> depth = flat_depth(photograph, 2);
  // Slopes on which neighbours are no edge, but pixels farther apart differ by more than one.
  const float slope = 0.008f * static_cast<float>(below(4));
  for (std::size_t pixel = 0; pixel < depth.size(); ++pixel) {
    depth[pixel] += slope * static_cast<float>(pixel % photograph.width);
  }
  if (seed % 2 == 0) photograph.valid.assign(depth.size(), 255);
  for (std::uint32_t spot = 0; spot < 1 + below(6); ++spot) {
    const std::size_t pixel = below(static_cast<std::uint32_t>(depth.size()));
    depth[pixel] = below(3) == 0 ? kNoSurface : 2 + 0.05f * static_cast<float>(below(8));
    if (!photograph.valid.empty()) photograph.valid[below(static_cast<std::uint32_t>(depth.size()))] = 0;
  }
  const ValidityOptions options{0.02 + 0.02 * below(4), below(4), below(7),
                                below(2) == 0 ? Edges::far_side : Edges::both_sides};
  CAPTURE(seed, slope, photograph.width, photograph.height, options.depth_edge, options.edge_radius_px, options.fade_px,
          options.edges);
  const Definition definition{photograph, depth, options};
  CHECK(validity_mask(photograph, depth, kAllTrusted, options) ==
        of_each_pixel(photograph, [&](int x, int y) { return definition.value(x, y); }));
  if (options.edges == Edges::far_side) {
    CHECK(rim_pixels(photograph, depth, options) ==
          of_each_pixel(photograph, [&](int x, int y) { return std::uint8_t{definition.at_rim(x, y)}; }));
  }
}

TEST_CASE("a contradicted pixel keeps the least validity, rather than none") {
  const Photograph photograph = grey(6, 1);
  const std::vector<std::uint8_t> trust{0, 1, 2, 128, 254, 255};
  CHECK(validity_mask(photograph, flat_depth(photograph, 3), trust, without_fade()) ==
        std::vector<std::uint8_t>{1, 1, 2, 128, 254, 255});
  CHECK(validity_mask(photograph, flat_depth(photograph, kNoSurface), trust, without_fade()) ==
        std::vector<std::uint8_t>(6, 0));
}

TEST_CASE("trust in every pixel is the same as no trust mask") {
  const Photograph photograph = grey(11, 11);
  const std::vector<float> depth = step_depth(photograph, 6, 1, 2);
  const std::vector<std::uint8_t> trust(11 * 11, 255);
  CHECK(validity_mask(photograph, depth, trust, {}) == validity_mask(photograph, depth, kAllTrusted, {}));
}

TEST_CASE("trust multiplies the faded mask, rounded, and makes no pixel invalid") {
  const Photograph photograph = grey(520, 520);
  std::vector<float> depth = flat_depth(photograph, 2);
  depth[0] = kNoSurface;
  const ValidityOptions options{0.05, 0, 16};
  std::mt19937 random(3);
  std::vector<std::uint8_t> trust(depth.size());
  for (std::uint8_t& value : trust) value = static_cast<std::uint8_t>(random() % 256);
  const auto without = validity_mask(photograph, depth, kAllTrusted, options);
  const auto with = validity_mask(photograph, depth, trust, options);
  REQUIRE(without[0] == 0);
  REQUIRE(*std::max_element(without.begin(), without.end()) == 255);
  std::size_t wrong = 0;
  for (std::size_t pixel = 0; pixel < with.size(); ++pixel) {
    const long product = std::lround(without[pixel] * std::max<int>(trust[pixel], 1) / 255.0);
    wrong += with[pixel] != (without[pixel] == 0 ? 0 : std::max(product, 1L));
  }
  CHECK(wrong == 0);
}

TEST_CASE("bad validity options are refused by field, value and rule") {
  const Photograph photograph = grey(2, 2);
  const auto sentence = [&](const ValidityOptions& options) -> std::string {
    try {
      (void)validity_mask(photograph, flat_depth(photograph, 1), kAllTrusted, options);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(sentence({0, 2, 8}) == "validity: depth_edge is 0, must be above 0 and at most 1000000");
  CHECK(sentence({std::nan(""), 2, 8}) == "validity: depth_edge is nan, must be above 0 and at most 1000000");
  CHECK(sentence({std::numeric_limits<double>::infinity(), 2, 8}) ==
        "validity: depth_edge is inf, must be above 0 and at most 1000000");
  CHECK(sentence({0.05, 17, 8}) == "validity: edge_radius_px is 17, must be at most 16");
  CHECK(sentence({0.05, 2, 17}) == "validity: fade_px is 17, must be at most 16");
  CHECK(sentence({0.05, 16, 16}) == "accepted");
  CHECK_THROWS_MATCHES(validity_mask(photograph, std::vector<float>(3, 1.0f), kAllTrusted, {}), std::invalid_argument,
                       Catch::Message("validity: depth has 3 values, must have one per pixel of the photograph"));
  CHECK_THROWS_MATCHES(
      validity_mask(photograph, flat_depth(photograph, 1), std::vector<std::uint8_t>(5, 255), {}),
      std::invalid_argument,
      Catch::Message("validity: trust has 5 values, must have one per pixel of the photograph, or none"));
}

}  // namespace
}  // namespace lumatlas
