// SPDX-License-Identifier: GPL-3.0-or-later
// The village: x and y in [-30, 30], two streets each way, houses and gardens in the blocks between them and at the
// outside, and a market place in the middle. Patterns are coarse enough for a camera 15 units away.
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>
#include <utility>

#include "tools/lab/synth/random.h"
#include "tools/lab/synth/shapes/builder.h"
#include "tools/lab/synth/shapes/polyhedron.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

constexpr double kHalfVillage = 0.5 * kVillageSide;
constexpr double kAir = 26;     // height of the air that cameras may be in
constexpr double kStreet = 11;  // distance of the streets' middles from the village's
constexpr double kStreetHalf = 2.5;

// The lines between streets and blocks, along x and y alike.
constexpr std::array kLines{-kHalfVillage,         -kStreet - kStreetHalf, -kStreet + kStreetHalf,
                            kStreet - kStreetHalf, kStreet + kStreetHalf,  kHalfVillage};

// A frame on the ground: `at` is the origin.
struct Frame {
  dvec2 at;
  double yaw;
  [[nodiscard]] dvec2 placed(dvec2 local) const {
    const double c = std::cos(yaw);
    const double s = std::sin(yaw);
    return at + dvec2(c * local.x - s * local.y, s * local.x + c * local.y);
  }
};

class Village : private SceneBuilder {
 public:
  explicit Village(std::uint64_t seed) : SceneBuilder(hashed(seed, 0x76696c6c)) {}

  Scene built() {
    make_ground();
    make_light();
    for (const int x : {0, 2, 4}) {
      for (const int y : {0, 2, 4}) {
        if (x != 2 || y != 2) make_block({kLines[x], kLines[y]}, {kLines[x + 1], kLines[y + 1]});
      }
    }
    make_market();
    make_ways();
    return std::move(scene_);
  }

 private:
  // Marks that fade over `softness`, so that a pixel of 0.1 units does them justice.
  std::int32_t add_soft(Pattern pattern, const Colors& colors, float scale, float softness) {
    const std::int32_t id = add(pattern, colors, scale);
    scene_.materials.back().softness = softness;
    return id;
  }

  Colors leafy() { return {tone(96, 140, 52), tone(140, 166, 72), tone(70, 106, 46)}; }

  void make_ground() {
    Block ground;
    ground.hollow = true;
    for (int x = 0; x < 5; ++x) {
      for (int y = 0; y < 5; ++y) {
        BlockPart air{{kLines[x], kLines[y], 0}, {kLines[x + 1], kLines[y + 1], kAir}, {}};
        air.material.fill(kOpen);
        air.material[4] = ground_of(x % 2 != 0 || y % 2 != 0, x == 2 && y == 2);
        ground.parts.push_back(air);
      }
    }
    scene_.solids.emplace_back(ground);
  }

  std::int32_t ground_of(bool street, bool market) {
    if (market)
      return add_soft(Pattern::cobbles, {tone(200, 186, 160), tone(158, 146, 128), tone(120, 110, 96)}, 2.4F, 0.4F);
    if (street)
      return add_soft(Pattern::cobbles, {tone(150, 142, 132), tone(112, 106, 100), tone(88, 84, 80)}, 1.5F, 0.35F);
    return add_soft(Pattern::grass, {tone(80, 120, 50), tone(130, 156, 70), vec3(0.1F)}, 2.4F, 0.3F);
  }

  void make_light() {
    sun(glm::normalize(dvec3(-0.5, -0.72, 0.85)), 0.025, vec3(0.74F, 0.7F, 0.62F));
    scene_.ambient_above = {0.32F, 0.36F, 0.42F};
    scene_.ambient_below = {0.19F, 0.18F, 0.14F};
    scene_.occlusion_reach = 3;
    scene_.sky = Sky{};
    scene_.sky->seed = static_cast<std::uint32_t>(random_.next());
  }

  // ---- Blocks of four lots.

  void make_block(dvec2 low, dvec2 high) {
    make_fences(low, high);
    for (const double x : {0.25, 0.75}) {
      for (const double y : {0.25, 0.75}) {
        const dvec2 at = glm::mix(low, high, dvec2(x, y));
        if (random_.uniform() < 0.78F) {
          make_house(at);
        } else {
          make_garden(at);
        }
      }
    }
  }

  // A low wall round the block, with a gate in the middle of each side.
  void make_fences(dvec2 low, dvec2 high) {
    constexpr double kInset = 0.35;
    const double length = 0.5 * (high.x - low.x) - 2;
    for (const double side : {-1.0, 1.0}) {
      for (const double part : {-1.0, 1.0}) {
        const dvec2 middle = 0.5 * (low + high);
        const dvec2 half = 0.5 * (high - low) - kInset;
        const double along = part * (1.2 + 0.5 * length);
        box(middle + dvec2(along, side * half.y), 0, {length, 0.25, 0.7}, stone_wall());
        box(middle + dvec2(side * half.x, along), 0, {0.25, length, 0.7}, stone_wall());
      }
    }
  }

  std::int32_t stone_wall() {  // overgrown
    return add_soft(Pattern::cobbles, {tone(128, 132, 92), tone(108, 118, 78), tone(90, 104, 64)}, 1.2F, 0.25F);
  }

  // ---- Houses.

  void make_house(dvec2 lot) {
    const dvec2 shift(random_.uniform(-0.3, 0.3), random_.uniform(-0.3, 0.3));
    const double quarter = random_.below(4);
    const Frame frame{lot + shift, 0.5 * std::numbers::pi * quarter + random_.uniform(-0.05, 0.05)};
    const dvec2 size(random_.uniform(5, 6), random_.uniform(4, 5));
    const int storeys = random_.uniform() < 0.5F ? 1 : 2;
    const double height = 2.9 * storeys;
    make_walls(frame, size, height);
    make_roof(frame, size, height);
    for (int storey = 0; storey < storeys; ++storey) {
      for (const int side : {0, 1, 2, 3}) make_windows(frame, size, side, 2.9 * storey + 1, storey == 0);
    }
  }

  void make_walls(const Frame& frame, dvec2 size, double height) {
    const std::uint32_t style = random_.below(3);
    const vec3 paint = 0.35F + 0.45F * dye();
    Block& walls = box(frame.at, 0, dvec3(size, height), 0, frame.yaw);
    walls.parts[0].material[5] = kOpen;  // under the roof
    for (const int side : {0, 1, 2, 3}) {
      std::int32_t& material = walls.parts[0].material[side];
      if (style == 0) material = add_soft(Pattern::cobbles, {paint, 0.8F * paint, 0.65F * paint}, 1.8F, 0.35F);
      if (style == 1) {
        material = add_soft(Pattern::bricks, {tone(176, 104, 80), tone(146, 80, 64), tone(186, 150, 130)}, 2, 0.25F);
      }
      if (style == 2) material = add_soft(Pattern::shingles, {paint, 0.85F * paint, 0.6F * paint}, 1.6F, 0.35F);
    }
  }

  void make_roof(const Frame& frame, dvec2 size, double height) {
    constexpr double kOverhang = 0.8;  // both sides together
    const double rise = random_.uniform(1.7, 2.5);
    const std::uint32_t style = random_.below(2);
    const Colors clay = style == 0 ? Colors{tone(186, 96, 66), tone(156, 76, 54), tone(112, 58, 44)}
                                   : Colors{tone(116, 122, 136), tone(88, 94, 108), tone(64, 68, 80)};
    const Colors boards{tone(160, 124, 86), tone(128, 96, 66), tone(104, 78, 54)};
    const auto gable = [&] { return add_soft(Pattern::bricks, boards, 2.4F, 0.3F); };
    const auto slope = [&] { return add_soft(Pattern::shingles, clay, 1.5F, 0.3F); };
    const std::int32_t first_slope = slope();
    Convex roof = gable_roof(size + kOverhang, rise, first_slope, gable());
    roof.sides[1].material = slope();
    roof.sides[3].material = gable();
    convex(roof, dvec3(frame.at, height - kSink), frame.yaw);
    const dvec2 chimney(0.28 * size.x, random_.uniform() < 0.5F ? -0.2 * size.y : 0.2 * size.y);
    const std::int32_t brick =
        add_soft(Pattern::bricks, {tone(160, 90, 72), tone(130, 72, 60), tone(170, 140, 124)}, 1.2F, 0.15F);
    box(frame.placed(chimney), height + 0.3 * rise, {0.6, 0.6, 0.9 * rise}, brick, frame.yaw);
  }

  // On one side of a house, numbered like those of a block; with a door among those at the ground in front.
  void make_windows(const Frame& frame, dvec2 size, int side, double bottom, bool ground) {
    const bool along_y = side / 2 == 0;
    const double width = along_y ? size.y : size.x;
    const double out = (side % 2 == 0 ? -0.5 : 0.5) * (along_y ? size.x : size.y);
    const int count = width > 5.4 ? 3 : 2;
    for (int i = 0; i < count; ++i) {
      const double along = width * ((i + 0.5) / count - 0.5);
      const dvec2 local = along_y ? dvec2(out, along) : dvec2(along, out);
      const Frame at{frame.placed(local), frame.yaw};
      if (ground && side == 2 && i == 1) {
        open_wall(at, side, 0.02, {1.05, 0.16, 2.1}, add(Pattern::letter, {0.6F * dye(), 0.5F * dye(), dye()}));
      } else {
        open_wall(at, side, bottom, {0.9, 0.14, 1.15}, pane());
      }
    }
  }

  // Glass in lead.
  std::int32_t pane() {
    const vec3 shade = 0.06F + 0.3F * dye();
    const std::int32_t id = add_glossy(Pattern::cobbles, {shade, 0.7F * shade, 0.6F * shade}, 0.9F, 0.08F);
    scene_.materials.back().softness = 0.25F;
    return id;
  }

  // A frame in a wall with something in it, towards `side`; half of its depth is in the wall.
  void open_wall(const Frame& frame, int side, double bottom, dvec3 size, std::int32_t leaf) {
    const vec3 paint = tone(200, 190, 172);
    const std::int32_t rim = add_soft(Pattern::cobbles, {paint, 0.8F * paint, 0.8F * paint}, 0.8F, 0.2F);
    if (side / 2 == 0) std::swap(size.x, size.y);
    Block& block = board(frame.at, bottom, size, rim, frame.yaw);
    block.parts[0].material[side ^ 1] = kOpen;
    block.parts[0].material[side] = leaf;
  }

  // ---- Gardens.

  void make_garden(dvec2 lot) {
    for (const dvec2 corner : {dvec2(-1, -1), dvec2(1, -1), dvec2(-1, 1), dvec2(1, 1)}) {
      const dvec2 at = lot + 1.9 * corner + dvec2(random_.uniform(-0.3, 0.3), random_.uniform(-0.3, 0.3));
      const std::uint32_t what = random_.below(4);
      if (what == 0) make_bush(at);
      if (what == 1) make_fir(at);
      if (what >= 2) make_tree(at);
    }
  }

  void make_trunk(dvec2 at, double height) {
    const Colors bark{tone(120, 92, 66), tone(94, 72, 54), tone(80, 60, 46)};
    convex_of(frustum({8, 0.22, 0.16, height}, 0, kOpen, kOpen), dvec3(at, -kSink), Pattern::bricks, bark, 0.6F, 0.15F);
  }

  // A ball of flat sides, `high` times as high as wide.
  Convex crown(double radius, double high) {
    const Polyhedron ball = icosahedron();
    Convex body;
    for (const dvec3& point : ball.points) {
      body.corners.push_back(radius * dvec3(1, 1, high) * glm::normalize(point));
    }
    for (const glm::uvec3& face : ball.faces) body.sides.push_back({{face.x, face.y, face.z}, 0});
    return body;
  }

  void make_tree(dvec2 at) {
    const double height = random_.uniform(1.4, 2);
    const double radius = random_.uniform(1, 1.35);
    make_trunk(at, height + 0.5);
    convex_of(crown(radius, 1.15), dvec3(at, height + 1.1 * radius), Pattern::foliage, leafy(), 1.2F, 0.2F);
  }

  void make_fir(dvec2 at) {
    make_trunk(at, 1.1);
    const Colors needles{tone(50, 100, 70), tone(76, 126, 76), tone(40, 80, 58)};
    for (const double step : {0.0, 1.0, 2.0}) {  // each ends under the next one's bottom
      const FrustumSize size{9, 1.3 - 0.3 * step, step < 2 ? 0.6 - 0.2 * step : 0, step < 2 ? 1 : 1.5};
      convex_of(frustum(size, 0, 0, kOpen), dvec3(at, 0.9 + (1 - kSink) * step), Pattern::foliage, needles, 1, 0.2F);
    }
  }

  void make_bush(dvec2 at) {
    const double radius = random_.uniform(0.6, 0.9);
    convex_of(crown(radius, 0.8), dvec3(at, 0.5 * radius), Pattern::foliage, leafy(), 1, 0.2F);
  }

  // ---- The market place, between the streets' inner lines.

  void make_market() {
    make_fountain({0, 0});
    make_tower({-4.6, 4.4});
    make_stall({4.4, 4.6});
    make_stall({5, -0.4});
    make_stall({3.6, -5});
    make_stall({-4.6, -4.6});
    for (const dvec2 at : {dvec2(-6.2, -1), dvec2(-0.6, 6.2), dvec2(6.6, 6.8), dvec2(0.2, -6.4)}) make_tree(at);
    for (const dvec2 at : {dvec2(-2.2, 5.4), dvec2(-6.6, 1.6), dvec2(2.4, 6)}) make_pile(at);
  }

  void make_fountain(dvec2 at) {
    const std::int32_t rim = stone_wall();
    const std::int32_t water =
        add_glossy(Pattern::cobbles, {tone(70, 130, 150), tone(90, 150, 166), tone(60, 110, 130)}, 1, 0.15F);
    cylinder(at, 0, 1.7, 0.6, rim, water);
    cylinder(at, 0.6, 0.28, 1.5, add(Pattern::bands, {dye(), dye(), dye()}, 0.4F), kOpen);
    sphere(dvec3(at, 2.4), 0.45, add(Pattern::globe, {dye(), dye(), dye()}));
  }

  void make_tower(dvec2 at) {
    const std::int32_t base =
        add_soft(Pattern::bricks, {tone(200, 188, 164), tone(170, 156, 134), tone(140, 128, 112)}, 2, 0.25F);
    Block& tower = box(at, 0, {3.4, 3.4, 7}, base);
    for (const int side : {1, 2, 3}) {
      tower.parts[0].material[side] =
          add_soft(Pattern::bricks, {tone(200, 188, 164), tone(170, 156, 134), tone(140, 128, 112)}, 2, 0.25F);
    }
    tower.parts[0].material[5] = kOpen;
    Convex roof = frustum({4, 2.75, 0, 3}, 0, 0, kOpen);
    roof.yaw = 0.25 * std::numbers::pi;
    for (ConvexSide& side : roof.sides) {
      side.material =
          add_soft(Pattern::shingles, {tone(90, 130, 120), tone(70, 110, 102), tone(56, 86, 80)}, 1.5F, 0.3F);
    }
    convex(roof, dvec3(at, 7 - kSink), 0.25 * std::numbers::pi);
    for (const int side : {0, 1, 2, 3}) {
      const double out = side % 2 == 0 ? -1.7 : 1.7;
      const dvec2 face = at + (side / 2 == 0 ? dvec2(out, 0) : dvec2(0, out));
      open_wall({face, 0}, side, 5, {1.5, 0.2, 1.5}, add(Pattern::letter, {vec3(0.7F), dye(), dye() * 0.3F}));
      open_wall({face, 0}, side, 1.4, {0.9, 0.14, 1.6}, pane());
    }
  }

  void make_stall(dvec2 at) {
    const Frame frame{at, random_.uniform(-0.3, 0.3)};
    const std::int32_t wood = add(Pattern::wood, {tone(160, 120, 80), tone(110, 80, 52), vec3(0.1F)}, 4);
    box(frame.at, 0, {2, 1.1, 0.9}, wood, frame.yaw).parts[0].material[5] =
        add(Pattern::print, {vec3(0.6F), dye(), dye() * 0.3F}, 0.4F);
    for (const double x : {-0.95, 0.95}) {
      for (const double y : {-0.8, 0.8}) {
        box(frame.placed({x, y}), 0, {0.12, 0.12, 2.2}, wood, frame.yaw).parts[0].material[5] = kOpen;
      }
    }
    const Colors cloth{vec3(0.7F), dye(), dye()};
    Convex roof = gable_roof({2.6, 2.2}, 0.8, add(Pattern::wallpaper, cloth, 0.6F), add(Pattern::bands, cloth, 0.5F));
    roof.sides[1].material = add(Pattern::wallpaper, cloth, 0.6F);
    convex(roof, dvec3(frame.at, 2.2 - kSink), frame.yaw);
  }

  // Crates with letters, one on two.
  void make_pile(dvec2 at) {
    crate(at - dvec2(0.55, 0), 0);
    crate(at + dvec2(0.55, 0), 0);
    crate(at, 0.9);
  }

  void crate(dvec2 at, double bottom) {
    Block& block = box(at, bottom, dvec3(0.9), 0, random_.uniform(-0.12, 0.12));
    for (const int side : {0, 1, 2, 3, 5}) {
      block.parts[0].material[side] = add(Pattern::letter, {dye() * 0.4F + 0.4F, dye(), dye() * 0.25F});
    }
  }

  // ---- Ways through it.

  // Along all streets at eye level, to and fro on the arms that lead out, turning within the street.
  void make_ways() {
    constexpr double kEye = 1.7;
    constexpr double kStep = 2.75;  // between control points
    const std::array<dvec2, 4> corners{dvec2(-1, -1), dvec2(1, -1), dvec2(1, 1), dvec2(-1, 1)};
    const auto add_line = [&](dvec2 from, dvec2 to) {  // without its end
      const int count = static_cast<int>(std::round(glm::distance(from, to) / kStep));
      for (int i = 0; i < count; ++i) {
        scene_.walk.emplace_back(glm::mix(from, to, static_cast<double>(i) / count), kEye);
      }
    };
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const dvec2 at = kStreet * corners[i];
      for (const dvec2 arm : {dvec2(corners[i].x, 0), dvec2(0, corners[i].y)}) {
        const dvec2 aside = 0.9 * dvec2(-arm.y, arm.x);
        const dvec2 end = at + (kHalfVillage - kStreet - 3.0) * arm;
        add_line(at - aside, end - aside);
        add_line(end - aside, end + aside);
        add_line(end + aside, at + aside);
      }
      add_line(at, kStreet * corners[(i + 1) % corners.size()]);
    }
    scene_.walk_gaze = {Gaze::Heading::ahead, 0, 0, 0.9, 24, -0.03, 0.12, 17};
    constexpr double kFlight = 22;  // half of its area's side
    scene_.flight = {{-kFlight, -kFlight, 13},
                     {2 * kFlight, 0, 0},
                     {0, 2 * kFlight, 0},
                     {Gaze::Heading::ahead, 0, 0, 0.35, 29, -0.9, 0.12, 23}};
    scene_.orbit = {{0, 0, 1}, {25, 25}, 15};
    scene_.stay = {{-28, -28, 1.5}, {28, 28, 14}, -1.2, 0.1};
    scene_.clearance = 0.5;
  }
};

}  // namespace

Scene untessellated_village(std::uint64_t seed) {
  return Village(seed).built();
}

Scene make_village(std::uint64_t seed, std::uint32_t triangles) {
  Scene scene = Village(seed).built();
  scene.geometry = tessellate(scene.solids, edge_for_faces(scene.solids, triangles));
  return scene;
}

}  // namespace lumatlas::synth
