// SPDX-License-Identifier: GPL-3.0-or-later
// The wall: a house front at y = 0 that faces -y, x in [-9, 9], z in [0, 11], and the pavement before it. Its relief
// goes down to bars of 2 cm, and its patterns to half a centimetre.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <span>
#include <vector>

#include "tools/lab/synth/random.h"
#include "tools/lab/synth/shapes/builder.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

constexpr double kHalfFront = 9;  // half of the front's width
constexpr double kHeight = 11;
constexpr double kFar = 9;        // how far before the front cameras may be
constexpr double kReveal = 0.22;  // depth of the windows' niches
constexpr int kBalconyColumns = 5;
constexpr int kStoreys = 3;
constexpr double kBay = 3.3;     // between the middles of two columns
constexpr double kStorey = 3.3;  // height of one

struct Opening {
  dvec2 low, high;  // x and z
  [[nodiscard]] dvec2 middle() const { return 0.5 * (low + high); }
  [[nodiscard]] dvec2 size() const { return high - low; }
};

class Wall : private SceneBuilder {
 public:
  explicit Wall(std::uint64_t seed) : SceneBuilder(hashed(seed, 0x77616c6c)) {}

  Scene built() {
    make_openings();
    make_front();
    make_light();
    make_plinth();
    make_quoins();
    for (int storey = 1; storey < kStoreys; ++storey) make_course(kStorey * storey);
    make_cornice();
    for (std::size_t i = 0; i < openings_.size(); ++i) trim(openings_[i], i == kDoor, i % 2 == 0);
    make_balcony(openings_[kBalcony]);
    make_bricks();
    make_ivy();
    make_ways();
    return std::move(scene_);
  }

 private:
  static constexpr std::size_t kDoor = 2;                       // the middle of the lowest row
  static constexpr std::size_t kBalcony = kBalconyColumns + 2;  // above it

  Colors clay() { return {tone(178, 104, 80), tone(132, 72, 58), tone(196, 186, 170)}; }
  std::int32_t stone() { return add(Pattern::plaster, {tone(210, 200, 178), vec3(0.5F), vec3(0.3F)}, 0.5F); }
  std::int32_t paint() { return add(Pattern::wood, {tone(226, 222, 210), tone(190, 182, 166), vec3(0.1F)}, 0.4F); }

  // ---- The front and the air before it.

  void make_openings() {
    for (int storey = 0; storey < kStoreys; ++storey) {
      for (int column = 0; column < kBalconyColumns; ++column) {
        const double x = kBay * (column - 0.5 * (kBalconyColumns - 1));
        const double bottom = kStorey * storey + 0.95;
        openings_.push_back({{x - 0.55, bottom}, {x + 0.55, bottom + 1.75}});
      }
    }
    openings_[kDoor].low = {-0.65, 0.02};
    openings_[kBalcony].low.y = kStorey + 0.2;
  }

  void make_front() {
    Block air;
    air.hollow = true;
    BlockPart before{{-kHalfFront, -kFar, 0}, {kHalfFront, 0, kHeight}, {}};
    before.material.fill(kOpen);
    before.material[3] = add(Pattern::bricks, clay(), 0.25F);
    before.material[4] = add(Pattern::cobbles, {tone(150, 142, 132), tone(104, 98, 94), tone(66, 62, 58)}, 0.16F);
    air.parts.push_back(before);
    for (std::size_t i = 0; i < openings_.size(); ++i) {
      const Opening& o = openings_[i];
      BlockPart niche{{o.low.x, 0, o.low.y}, {o.high.x, kReveal, o.high.y}, {}};
      const std::int32_t jamb = stone();
      niche.material.fill(jamb);
      niche.material[3] = i == kDoor ? add(Pattern::wood, {0.5F * dye(), 0.3F * dye(), vec3(0.1F)}, 0.5F) : glass();
      air.parts.push_back(niche);
    }
    scene_.solids.emplace_back(air);
  }

  // A curtain hangs behind it.
  std::int32_t glass() {
    const vec3 cloth = 0.05F + 0.35F * dye();
    return add_glossy(Pattern::fabric, {cloth, 0.6F * cloth, dye() * 0.6F}, 1.2F, 0.09F);
  }

  void make_light() {
    sun(glm::normalize(dvec3(-0.55, -0.8, 0.75)), 0.04, vec3(0.8F, 0.75F, 0.66F));
    scene_.ambient_above = {0.3F, 0.34F, 0.4F};
    scene_.ambient_below = {0.22F, 0.21F, 0.18F};
    scene_.occlusion_reach = 0.8F;
    scene_.sky = Sky{};
    scene_.sky->seed = static_cast<std::uint32_t>(random_.next());
  }

  // ---- Relief. All of it is sunk into the front, and open there.

  // A box on the front: x and z of its lower left corner, its size, and how far it stands out.
  Block& relief(dvec2 low, dvec2 size, double out, std::int32_t material) {
    Block& block = board({low.x + 0.5 * size.x, 0.5 * (kSink - out)}, low.y, {size.x, out + kSink, size.y}, material);
    block.parts[0].material[3] = kOpen;
    return block;
  }

  [[nodiscard]] bool overlaps_opening(dvec2 low, dvec2 high, double margin) const {
    for (const Opening& o : openings_) {
      const bool apart = high.x < o.low.x - margin || low.x > o.high.x + margin || high.y < o.low.y - margin ||
                         low.y > o.high.y + margin;
      if (!apart) return true;
    }
    return false;
  }

  // Two rows of blocks along the ground.
  void make_plinth() {
    constexpr double kLength = 0.9;
    constexpr double kRow = 0.34;
    for (int row = 0; row < 2; ++row) {
      for (int i = 0; i < 19; ++i) {
        const dvec2 low(-kHalfFront + 0.04 + 0.94 * i - (row == 1 && i > 0 ? 0.45 : 0), 0.01 + (kRow + 0.03) * row);
        const double length = std::min(row == 1 && i == 0 ? kLength - 0.45 : kLength, kHalfFront - 0.04 - low.x);
        if (overlaps_opening(low, low + dvec2(length, kRow), 0.2)) continue;
        relief(low, {length, kRow}, random_.uniform(0.05, 0.08), stone());
      }
    }
  }

  // Cornerstones, long and short by turns.
  void make_quoins() {
    for (const double side : {-1.0, 1.0}) {
      for (int i = 0; i < 28; ++i) {
        const double z = 0.85 + 0.34 * i;
        if (z + 0.3 > kHeight - 0.7) break;
        if (std::abs(std::remainder(z + 0.15, kStorey)) < 0.32) continue;  // room for the courses
        const double length = i % 2 == 0 ? 0.6 : 0.4;
        const double x = side < 0 ? -kHalfFront + 0.01 : kHalfFront - 0.01 - length;
        relief({x, z}, {length, 0.3}, 0.045, stone());
      }
    }
  }

  // A moulding along the whole front: boards on each other, each with its own depth.
  void moulding(double bottom, std::span<const dvec2> heights_and_depths) {
    double z = bottom;
    for (const dvec2& step : heights_and_depths) {
      relief({-kHalfFront + 0.005, z}, {2 * kHalfFront - 0.01, step.x}, step.y, stone());
      z += step.x + 1e-3;
    }
  }

  void make_course(double z) {
    moulding(z - 0.12, std::array{dvec2(0.05, 0.04), dvec2(0.08, 0.09), dvec2(0.04, 0.06)});
  }

  void make_cornice() {
    moulding(kHeight - 0.62, std::array{dvec2(0.06, 0.05), dvec2(0.2, 0.08)});
    for (double x = -kHalfFront + 0.1; x < kHalfFront - 0.15; x += 0.24) {  // dentils
      relief({x, kHeight - 0.355}, {0.12, 0.12}, 0.2, stone());
    }
    moulding(kHeight - 0.23, std::array{dvec2(0.08, 0.3), dvec2(0.1, 0.36)});
  }

  // Adds the frame of an opening and what is in it.
  void trim(const Opening& o, bool door, bool gabled) {
    constexpr double kWide = 0.14;
    const dvec2 low = o.low - kWide;
    const dvec2 size = o.size() + 2 * kWide;
    for (const double x : {low.x, o.high.x + 1e-3}) relief({x, o.low.y}, {kWide - 1e-3, o.size().y}, 0.05, stone());
    relief({low.x, o.high.y + 1e-3}, {size.x, kWide}, 0.06, stone());
    if (!door) {
      relief({low.x - 0.06, o.low.y - 0.09}, {size.x + 0.12, 0.08}, 0.14, stone());
      make_lattice(o);
    }
    if (gabled) {
      make_pediment({o.middle().x, o.high.y + kWide + 2e-3}, size.x + 0.1);
    } else {
      relief({low.x - 0.05, o.high.y + kWide + 2e-3}, {size.x + 0.1, 0.09}, 0.15, stone());
    }
    if (door) make_panels(o);
  }

  // Bars before the glass.
  void make_lattice(const Opening& o) {
    const std::int32_t wood = paint();
    const double y = kReveal - 0.02;
    const double height = o.size().y - 0.01;
    for (const double x : {0.03, 0.5 * o.size().x, o.size().x - 0.03}) {
      board({o.low.x + x, y}, o.low.y + 0.005, {0.05, 0.05, height}, wood);
    }
    for (const double z : {0.03, 0.55, 1.1}) {
      for (const double x : {0.28, 0.82}) {
        board({o.low.x + x, y + 0.005}, o.low.y + z, {0.45, 0.03, 0.035}, wood);
      }
    }
  }

  void make_panels(const Opening& o) {
    for (const double x : {0.08, 0.69}) {
      for (int row = 0; row < 4; ++row) {
        const std::int32_t panel = add(Pattern::letter, {dye() * 0.5F, dye() * 0.4F, dye()});
        board({o.low.x + x + 0.24, kReveal - 0.01}, o.low.y + 0.1 + 0.64 * row, {0.48, 0.05, 0.54}, panel);
      }
    }
  }

  // A flat gable of triangular section.
  void make_pediment(dvec2 at, double width) {
    constexpr double kOut = 0.15;
    Convex gable;
    const double half = 0.5 * width;
    gable.corners = {{-half, -kOut, 0}, {half, -kOut, 0}, {0, -kOut, 0.34},
                     {-half, kSink, 0}, {half, kSink, 0}, {0, kSink, 0.34}};
    const std::int32_t front = add(Pattern::rug, {dye(), tone(210, 200, 178), dye() * 0.6F}, 0.12F);
    gable.sides = {{{0, 1, 2}, front},
                   {{4, 3, 5}, kOpen},
                   {{1, 4, 5, 2}, stone()},
                   {{3, 0, 2, 5}, stone()},
                   {{3, 4, 1, 0}, stone()}};
    convex(gable, {at.x, 0, at.y});
  }

  // A slab on brackets, with a railing of thin bars.
  void make_balcony(const Opening& o) {
    constexpr double kOut = 0.95;
    constexpr double kWide = 3;
    const double x = o.middle().x;
    const double floor = o.low.y - 0.1;  // under the sill
    relief({x - 0.5 * kWide, floor - 0.14}, {kWide, 0.14}, kOut, stone());
    for (const double side : {-1.1, 1.1}) make_bracket({x + side, floor - 0.14});
    const std::int32_t iron = add(Pattern::plain, {vec3(0.03F), vec3(0.03F), vec3(0.03F)});
    const double rail = floor + 1;
    const double y = -kOut + 0.06;
    const double half = 0.5 * kWide - 0.06;
    board({x, y}, rail, {2 * half + 0.05, 0.05, 0.04}, iron);
    for (const double side : {-half, half}) board({x + side, 0.5 * y + 0.01}, rail, {0.05, -y - 0.03, 0.04}, iron);
    const auto bar = [&](dvec2 at) { box(at, floor, {0.022, 0.022, 1 + kSink}, iron).parts[0].material[5] = kOpen; };
    for (int i = 0; i <= 24; ++i) bar({x - half + 2 * half * i / 24, y});
    for (int i = 1; i < 8; ++i) {
      for (const double side : {-half, half}) bar({x + side, y * (1 - i / 8.0)});
    }
  }

  void make_bracket(dvec2 at) {
    constexpr double kOut = 0.7;
    Convex bracket;
    bracket.corners = {{-0.09, kSink, -0.5},  {0.09, kSink, -0.5},  {0.09, kSink, kSink},
                       {-0.09, kSink, kSink}, {0.09, -kOut, kSink}, {-0.09, -kOut, kSink}};
    bracket.sides = {{{5, 0, 1, 4}, stone()},
                     {{1, 2, 4}, stone()},
                     {{0, 5, 3}, stone()},
                     {{3, 5, 4, 2}, kOpen},
                     {{0, 3, 2, 1}, kOpen}};
    convex(bracket, {at.x, 0, at.y});
  }

  // Bricks that stand out, on the front's own rows; none where anything else is.
  void make_bricks() {
    constexpr double kLength = 0.25;
    constexpr double kRow = 0.36 * kLength;
    for (int i = 0; i < 700; ++i) {
      const auto row = static_cast<int>(random_.uniform(9, (kHeight - 0.75) / kRow));
      const auto column = static_cast<int>(random_.uniform(4, 2 * kHalfFront / kLength - 5));
      const dvec2 low(-kHalfFront + (column - (row % 2 == 1 ? 0.5 : 0)) * kLength + 0.006, row * kRow + 0.006);
      const dvec2 size(kLength - 0.012, kRow - 0.012);
      const bool in_course = std::abs(std::remainder(low.y + 0.5 * kRow, kStorey)) < 0.2;
      if (in_course || overlaps_opening(low, low + size, 0.6) || !place(low, low + size)) continue;
      relief(low, size, random_.uniform(0.012, 0.035),
             add(Pattern::plaster, {dyed_clay(), vec3(0.5F), vec3(0.3F)}, 0.2F));
    }
  }

  vec3 dyed_clay() {
    const vec3 base = tone(150, 86, 66);
    return glm::mix(base, dye(), 0.25F);
  }

  // Returns false if something that was placed is there already.
  bool place(dvec2 low, dvec2 high) {
    for (const Opening& other : placed_) {
      if (high.x > other.low.x && low.x < other.high.x && high.y > other.low.y && low.y < other.high.y) return false;
    }
    placed_.push_back({low, high});
    return true;
  }

  // Leaves between two columns, in clusters that climb up, each before the front and clear of the others.
  void make_ivy() {
    for (const double stem : {-4.95, 1.65, 4.95}) {
      const double top = random_.uniform(4, 9);
      for (int i = 0; i < 500; ++i) {
        const double z = 0.9 + (top - 0.9) * random_.uniform(0, 1);
        const double reach = 0.62 * (1 - 0.6 * z / top) + 0.15;
        const dvec2 at(stem + reach * random_.uniform(-1, 1) + 0.15 * std::sin(2.3 * z), z);
        const double size = random_.uniform(0.06, 0.12);
        const bool in_course = std::abs(std::remainder(z, kStorey)) < 0.3;
        if (in_course || overlaps_opening(at - size, at + size, 0.25) || !place(at - size, at + size)) continue;
        make_leaf(at, size);
      }
    }
  }

  // Two pyramids base to base, flat, with their tip down.
  void make_leaf(dvec2 at, double size) {
    const double y = -random_.uniform(0.03, 0.12);
    const double lean = random_.uniform(-0.4, 0.4);
    const double thick = 0.2 * size;
    const auto turned = [&](dvec2 p) {
      return size * dvec3(std::cos(lean) * p.x - std::sin(lean) * p.y, 0, std::sin(lean) * p.x + std::cos(lean) * p.y);
    };
    Convex leaf;
    leaf.corners = {turned({0, -0.95}),   turned({0.65, 0.1}), turned({0, 0.6}),
                    turned({-0.65, 0.1}), {0, -thick, 0},      {0, thick, 0}};
    for (std::uint32_t i = 0; i < 4; ++i) {
      leaf.sides.push_back({{i, (i + 1) % 4, 4}, 0});
      leaf.sides.push_back({{(i + 1) % 4, i, 5}, 0});
    }
    const vec3 green = tone(70, 120, 44);
    convex_of(leaf, {at.x, y, at.y}, Pattern::foliage, {green, tone(130, 160, 70), 0.5F * green}, 0.03F);
  }

  // ---- Ways before it: rows at two distances, up and down again.

  void make_ways() {
    constexpr double kStep = 2.4;  // between control points
    const auto add_row = [&](double y, double z, bool forth) {
      for (int i = 0; i <= 6; ++i) scene_.walk.emplace_back((forth ? 1 : -1) * kStep * (i - 3), y, z);
    };
    bool forth = true;
    for (const double z : {1.4, 3.1, 4.8, 6.5, 8.2, 9.8}) {
      add_row(-3, z, forth);
      forth = !forth;
    }
    for (const double z : {8.6, 5.6, 2.6}) {
      add_row(-6.8, z, forth);
      forth = !forth;
    }
    const double front = 0.5 * std::numbers::pi;
    scene_.walk_gaze = {Gaze::Heading::fixed, front, 0, 0.3, 13, 0, 0.12, 19};
    scene_.flight = {{-7.5, -4.5, 1}, {15, 0, 0}, {0, 0, 9.2}, {Gaze::Heading::fixed, front, 0, 0.3, 13, 0, 0.12, 19}};
    scene_.orbit = {{0, 0, 5}, {7.5, 7.5}, 5.5};
    scene_.stay = {{-7.5, -7.5, 1}, {7.5, -1.5, 10}, -0.4, 0.3};
  }

  std::vector<Opening> openings_;
  std::vector<Opening> placed_;  // bricks and leaves
};

}  // namespace

Scene make_wall(std::uint64_t seed, std::uint32_t triangles) {
  Scene scene = Wall(seed).built();
  scene.geometry = tessellate(scene.solids, edge_for_faces(scene.solids, triangles));
  return scene;
}

}  // namespace lumatlas::synth
