// SPDX-License-Identifier: GPL-3.0-or-later
// The laboratory: one cluttered room, x in [0, 7.2] and y in [0, 5.2]. Much of it is what depth sensors fail at: thin
// rods and cables, dark screens, gloss, bare metal, narrow gaps.
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "tools/lab/synth/random.h"
#include "tools/lab/synth/shapes/furniture.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;
using glm::vec3;

constexpr double kLabLength = 7.2;  // along x
constexpr double kLabWidth = 5.2;   // along y
constexpr double kLabHeight = 2.8;
constexpr double kBench = 0.9;  // height of what is worked at standing
constexpr double kDesk = 0.74;

class Lab : private Furnisher {
 public:
  explicit Lab(std::uint64_t seed) : Furnisher(hashed(seed, 0x6c6162)) {}

  Scene furnished() {
    make_room();
    make_lights();
    rack({0.24, 3.0});
    workbench({3.3, kLabWidth - 0.37});
    island({3.6, 2.5});
    glossy_cabinet({kLabLength - 0.27, 3.1});
    desk({5.6, 0.38});
    lamp_stand({0.75, 0.7});
    gas_bottles({0.3, 1.2});
    boxes({6.55, 4.6});
    balls();
    pipes();
    cables();
    pictures();
    make_walk();
    return std::move(scene_);
  }

 private:
  // ---- The room.

  void make_room() {
    const std::int32_t ceiling = add(Pattern::tiles, {tone(226, 226, 222), tone(210, 212, 210), vec3(0.45F)}, 0.6F);
    const std::int32_t wall = add(Pattern::plaster, {tone(206, 206, 196), vec3(0.5F), vec3(0.3F)});
    const std::int32_t accent = add(Pattern::wallpaper, {tone(150, 170, 176), tone(166, 182, 184), dye() * 0.6F}, 0.3F);
    const std::int32_t floor =
        add_glossy(Pattern::tiles, {tone(168, 172, 176), tone(120, 128, 134), dye() * 0.6F}, 0.45F, 0.06F);
    const std::int32_t jamb =
        add(Pattern::wood, {linear_from_srgb(222, 214, 200), linear_from_srgb(196, 184, 164), vec3(0.1F)});
    const std::int32_t outside =
        add_emission(Pattern::sky, linear_from_srgb(120, 168, 226), linear_from_srgb(236, 238, 240), 1.15F);
    std::vector<BlockPart> air(2);
    air[0] = {{0, 0, 0}, {kLabLength, kLabWidth, kLabHeight}, {wall, accent, wall, wall, floor, ceiling}};
    air[1] = {{kLabLength, 1.1, 1.0}, {kLabLength + 0.2, 2.1, 2.2}, {jamb, outside, jamb, jamb, jamb, jamb}};
    scene_.solids.emplace_back(Block{{}, 0, air, true});
  }

  void make_lights() {
    const vec3 white(0.95F, 0.95F, 0.9F);
    ceiling_panel({1.9, 2.6}, {1.2, 0.5}, kLabHeight, kLampRadiance * white);
    ceiling_panel({5.2, 2.6}, {1.2, 0.5}, kLabHeight, kLampRadiance * white);
    const vec3 day(0.72F, 0.86F, 1.0F);
    scene_.lights.push_back({{kLabLength + 0.16F, 2.1F, 1.0F}, {0, -1.0F, 0}, {0, 0, 1.2F}, 4.0F * day});  // towards -x
    scene_.ambient_above = {0.2F, 0.2F, 0.2F};
    scene_.ambient_below = {0.32F, 0.31F, 0.29F};
  }

  // ---- What stands in it.

  // Open shelves along the west wall, full of books and boxes; their posts are 3 cm.
  void rack(dvec2 at) {
    const std::int32_t steel = add(Pattern::plain, {vec3(0.3F, 0.33F, 0.36F), vec3(0.3F), vec3(0.3F)});
    constexpr double kHalf = 1.1;
    constexpr double kDepth = 0.4;
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-kHalf, 0.0, kHalf}) {
        box(at + dvec2(x * (kDepth - 0.03), y), 0, {0.03, 0.03, 2.1}, steel);
      }
    }
    constexpr double kPitch = 0.5;
    for (int shelf = 0; shelf < 5; ++shelf) {
      const double z = 0.08 + kPitch * shelf;
      board(at, z, {kDepth - 0.004, 2 * kHalf - 0.004, 0.025}, oak());
      if (shelf == 4) continue;
      fill_shelf(at - dvec2(0, 0.5 * kHalf), z + 0.025, 0.5 * kHalf - 0.06, kPitch - 0.1);
      storage_boxes(at + dvec2(0, 0.5 * kHalf), z + 0.025, 0.5 * kHalf - 0.06);
    }
  }

  void storage_boxes(dvec2 at, double bottom, double half_width) {
    double y = -half_width;
    while (y < half_width - 0.2) {
      const double wide = random_.uniform(0.14, 0.26);
      const double deep = random_.uniform(0.22, 0.3);
      const double high = random_.uniform(0.12, 0.34);
      const double shift = random_.uniform(-0.03, 0.03);
      letter_box(at + dvec2(shift, y + 0.5 * wide), bottom, {deep, wide, high}, random_.uniform(-0.08, 0.08));
      y += wide + random_.uniform(0.03, 0.1);
    }
  }

  void letter_box(dvec2 at, double bottom, dvec3 size, double yaw) {
    Block& block = box(at, bottom, size, 0, yaw);
    for (const int face : {0, 1, 2, 3, 5}) {
      block.parts[0].material[face] = add(Pattern::letter, {dye() * 0.4F + 0.3F, dye(), dye() * 0.25F});
    }
  }

  // Along the north wall.
  void workbench(dvec2 at) {
    const std::int32_t top = oak();
    board(at, kBench - 0.04, {3.8, 0.7, 0.04}, top);
    legs(at, {3.8, 0.7}, kBench - 0.04, 0.05, top);
    monitor(at + dvec2(-1.2, 0.12), kBench, 0.56, random_.uniform(-0.25, 0));
    monitor(at + dvec2(-0.55, 0.14), kBench, 0.5, random_.uniform(0, 0.25));
    keyboard(at + dvec2(-0.9, -0.18), kBench);
    mug(at + dvec2(-0.35, -0.15), kBench);
    instrument(at + dvec2(0.4, 0.1), kBench, 0.1);
    instrument(at + dvec2(0.95, 0.12), kBench, -0.15);
    for (int i = 0; i < 4; ++i) {
      book_lying(at + dvec2(1.5, 0.02), kBench + 0.035 * i, random_.uniform(-0.5, 0.5));
    }
    tube_rack(at + dvec2(0.65, -0.2));
    wall_shelf(at + dvec2(0.9, 0.2), 1.62);
    chair(at + dvec2(-0.9, -0.72), random_.uniform(-0.3, 0.3));
    letter_box(at + dvec2(-1.5, 0.05), 0, {0.4, 0.35, 0.45}, random_.uniform(-0.2, 0.2));
    letter_box(at + dvec2(0.3, 0.1), 0, {0.5, 0.4, 0.3}, random_.uniform(-0.2, 0.2));
  }

  void monitor(dvec2 at, double bottom, double width, double yaw) {
    const std::int32_t dark = add_glossy(Pattern::plain, {vec3(0.02F), vec3(0.02F), vec3(0.02F)}, 1, 0.05F);
    const std::int32_t picture = add_glossy(Pattern::screen, {dye(), dye(), dye() * 0.5F + 0.4F}, 1, 0.05F);
    box(at, bottom, {0.24, 0.18, 0.015}, dark, yaw);
    box(at, bottom + 0.015, {0.06, 0.03, 0.14}, dark, yaw);
    board(at, bottom + 0.11, {width, 0.035, 0.62 * width}, dark, yaw).parts[0].material[2] = picture;
  }

  void keyboard(dvec2 at, double bottom) {
    const std::int32_t keys = add(Pattern::print, {vec3(0.08F), vec3(0.1F), vec3(0.02F)}, 0.035F);
    box(at, bottom, {0.42, 0.14, 0.02}, keys, random_.uniform(-0.2, 0.2));
  }

  void mug(dvec2 at, double bottom) {
    const std::int32_t glaze = add(Pattern::bands, {dye(), dye(), dye()}, 0.04F);
    cylinder(at, bottom, 0.042, 0.1, glaze, matte(vec3(0.04F)));
  }

  // A box with a printed front, knobs of metal and a handle of wire.
  void instrument(dvec2 at, double bottom, double yaw) {
    const std::int32_t body = add(Pattern::plain, {tone(150, 156, 150), vec3(0.3F), vec3(0.3F)});
    Block& block = box(at, bottom, {0.42, 0.3, 0.22}, body, yaw);
    block.parts[0].material[2] = add(Pattern::print, {vec3(0.5F, 0.5F, 0.46F), dye(), vec3(0.04F)}, 0.06F);
    const std::int32_t steel = add_metal(vec3(0.75F, 0.76F, 0.78F), 0.05F);
    const auto place = [&](double x, double y, double z) {
      return dvec3(at, bottom) + dvec3(std::cos(yaw) * x - std::sin(yaw) * y, std::sin(yaw) * x + std::cos(yaw) * y, z);
    };
    for (const double x : {-0.12, 0.0, 0.12}) pipe(place(x, -0.149, 0.05), place(x, -0.18, 0.05), 0.018, steel);
    for (const double x : {-0.14, 0.14}) pipe(place(x, 0, 0.218), place(x, 0, 0.26), 0.006, steel);
    pipe(place(-0.146, 0, 0.26), place(0.146, 0, 0.26), 0.006, steel);
  }

  void tube_rack(dvec2 at) {
    const std::int32_t wood = oak();
    box(at, kBench, {0.34, 0.08, 0.02}, wood);
    for (int i = 0; i < 6; ++i) {
      const std::int32_t glass = add_glossy(Pattern::plain, {dye(), vec3(0.1F), vec3(0.1F)}, 1, 0.2F);
      cylinder(at + dvec2(-0.125 + 0.05 * i, 0), kBench + 0.02, 0.011, random_.uniform(0.1, 0.16), glass, glass);
    }
  }

  void wall_shelf(dvec2 at, double height) {
    const std::int32_t wood = oak();
    board(at, height, {1.6, 0.26, 0.025}, wood);
    double x = -0.72;
    while (x < 0.66) {
      const double radius = random_.uniform(0.035, 0.06);
      const double high = random_.uniform(0.12, 0.26);
      const std::int32_t glaze = add_glossy(Pattern::bands, {dye(), dye(), dye()}, 0.05F, 0.05F);
      cylinder(at + dvec2(x + radius, random_.uniform(-0.03, 0.03)), height + 0.025, radius, high, glaze, glaze);
      x += 2 * radius + random_.uniform(0.02, 0.08);
    }
  }

  // Adds the island in the middle of the room.
  void island(dvec2 at) {
    const std::int32_t body = add(Pattern::wood, {dye() * 0.4F + 0.3F, dye() * 0.3F + 0.1F, vec3(0.1F)}, 1.2F);
    const std::int32_t top = add(Pattern::tiles, {tone(60, 66, 70), tone(90, 96, 100), dye()}, 0.2F);
    box(at, 0.06, {1.3, 0.62, kBench - 0.1}, body);
    box(at, 0, {1.2, 0.52, 0.06}, matte(vec3(0.05F)));
    board(at, kBench - 0.04, {1.5, 0.8, 0.04}, top);
    const std::int32_t brass = add_metal({0.95F, 0.76F, 0.42F}, 0.02F);
    sphere(dvec3(at + dvec2(-0.4, 0.12), kBench + 0.13 - kSink), 0.13, brass);
    tripod(dvec3(at + dvec2(0.12, 0.05), kBench));
    letter_box(at + dvec2(0.5, -0.16), kBench, {0.2, 0.2, 0.2}, random_.uniform(0, 0.8));
    letter_box(at + dvec2(0.5, -0.16), kBench + 0.2, {0.13, 0.13, 0.13}, random_.uniform(0, 0.8));
    const std::int32_t glaze = add_glossy(Pattern::bands, {dye(), dye(), dye()}, 0.06F, 0.05F);
    cylinder(at + dvec2(-0.15, -0.22), kBench, 0.07, 0.22, glaze, matte(vec3(0.02F)));
    for (int i = 0; i < 3; ++i) book_lying(at + dvec2(0.52, 0.2), kBench + 0.035 * i, random_.uniform(-0.4, 0.4));
  }

  // Three thin legs, a rod, and a clamp with a ball.
  void tripod(dvec3 at) {
    const std::int32_t steel = add_metal(vec3(0.62F, 0.63F, 0.65F), 0.1F);
    const dvec3 hub = at + dvec3(0, 0, 0.14);
    for (int leg = 0; leg < 3; ++leg) {
      const double angle = leg * 2 * std::numbers::pi / 3 + 0.4;
      pipe(at + 0.16 * dvec3(std::cos(angle), std::sin(angle), 0), hub, 0.007, steel);
    }
    pipe(hub - dvec3(0, 0, 0.03), at + dvec3(0, 0, 0.55), 0.009, steel);
    pipe(at + dvec3(0, 0, 0.46), at + dvec3(0.2, 0.06, 0.46), 0.006, steel);
    const std::int32_t earth = add(Pattern::globe, {linear_from_srgb(52, 96, 168), linear_from_srgb(96, 140, 66),
                                                    linear_from_srgb(206, 178, 120)});
    sphere(at + dvec3(0.26, 0.078, 0.46), 0.065, earth);
  }

  // Adds a cabinet by the east wall, with a front that mirrors a third of the light.
  void glossy_cabinet(dvec2 at) {
    const std::int32_t lacquer = add_glossy(Pattern::wood, {dye() * 0.5F, dye() * 0.3F, vec3(0.1F)}, 1.2F, 0.35F);
    box(at, 0, {0.5, 1.3, 1.15}, lacquer);
    const std::int32_t steel = add_metal(vec3(0.8F), 0.05F);
    for (const double y : {-0.06, 0.06}) {
      const dvec3 foot(at + dvec2(-0.28, y), 0.5);
      pipe(foot, foot + dvec3(0, 0, 0.3), 0.008, steel);
      for (const double z : {0.02, 0.28}) pipe(foot + dvec3(0, 0, z), foot + dvec3(0.04, 0, z), 0.007, steel);
    }
    const std::int32_t copper = add_metal({0.93F, 0.6F, 0.48F}, 0.06F);
    cylinder(at + dvec2(0, -0.4), 1.15, 0.12, 0.26, copper, matte(vec3(0.03F)));
    letter_box(at + dvec2(0, 0.35), 1.15, {0.3, 0.36, 0.24}, 0.2);
  }

  void desk(dvec2 at) {
    const std::int32_t wood = oak();
    board(at, kDesk - 0.04, {1.6, 0.7, 0.04}, wood);
    legs(at, {1.6, 0.7}, kDesk - 0.04, 0.05, wood);
    // Turned round: its screen looks to the north.
    monitor(at + dvec2(-0.3, -0.08), kDesk, 0.6, std::numbers::pi + random_.uniform(-0.2, 0.2));
    keyboard(at + dvec2(-0.3, 0.2), kDesk);
    for (int i = 0; i < 5; ++i) book_lying(at + dvec2(0.4, -0.1), kDesk + 0.035 * i, random_.uniform(-0.4, 0.4));
    mug(at + dvec2(0.62, 0.15), kDesk);
    chair(at + dvec2(-0.2, 0.7), random_.uniform(2.9, 3.4));
    letter_box(at + dvec2(0.55, 0), 0, {0.36, 0.4, 0.5}, 0);
  }

  void lamp_stand(dvec2 at) {
    const std::int32_t steel = add_metal(vec3(0.6F, 0.6F, 0.62F), 0.1F);
    const std::int32_t shade =
        add(Pattern::bands, {linear_from_srgb(236, 220, 180), linear_from_srgb(200, 150, 110), dye()}, 0.12F);
    cylinder(at, 0, 0.15, 0.025, steel, steel);
    pipe(dvec3(at, 0.02), dvec3(at, 1.5), 0.012, matte(vec3(0.25F)));
    scene_.solids.emplace_back(Cylinder{dvec3(at, 1.45), 0.17, 0.26, shade, shade, shade});
  }

  void gas_bottles(dvec2 at) {
    for (const double y : {0.0, 0.32}) {
      const std::int32_t paint = add_glossy(Pattern::bands, {dye(), dye(), dye()}, 0.4F, 0.08F);
      cylinder(at + dvec2(0, y), 0, 0.12, 1.3, paint, paint);
      const std::int32_t valve = add_metal({0.9F, 0.75F, 0.45F}, 0.08F);
      cylinder(at + dvec2(0, y), 1.3, 0.03, 0.14, valve, valve);
    }
  }

  // Cardboard, in the corner.
  void boxes(dvec2 at) {
    const auto turn = [&] { return random_.uniform(-0.25, 0.25); };
    letter_box(at, 0, {0.6, 0.55, 0.45}, turn());
    letter_box(at + dvec2(0.02, 0), 0.45, {0.5, 0.45, 0.4}, turn());
    letter_box(at, 0.85, {0.35, 0.35, 0.3}, turn());
    letter_box(at + dvec2(-0.75, 0.1), 0, {0.5, 0.45, 0.35}, turn());
    letter_box(at + dvec2(-0.72, 0.1), 0.35, {0.3, 0.3, 0.25}, turn());
  }

  void balls() {
    for (const dvec2 at : {dvec2(2.3, 0.5), dvec2(2.85, 0.75), dvec2(1.3, 4.3), dvec2(6.2, 3.9)}) {
      const double radius = random_.uniform(0.1, 0.2);
      const std::int32_t skin = add(Pattern::bands, {dye(), dye(), dye()}, static_cast<float>(0.4 * radius));
      sphere(dvec3(at, radius - kSink), radius, skin);
    }
  }

  // ---- What hangs on the walls.

  void pipes() {
    const std::int32_t paint = add(Pattern::bands, {tone(200, 196, 186), tone(170, 60, 50), tone(190, 188, 180)}, 0.6F);
    const std::int32_t steel = add_metal(vec3(0.7F, 0.72F, 0.75F), 0.08F);
    const dvec3 west(0.12, kLabWidth - 0.12, 2.55);
    const dvec3 east(kLabLength - 0.12, kLabWidth - 0.12, 2.55);
    pipe(west, east, 0.05, paint);
    pipe(dvec3(west.x, west.y, 0), west, 0.05, paint);
    pipe(dvec3(east.x, east.y, 0.9), east, 0.05, paint);
    sphere(west, 0.062, paint);
    sphere(east, 0.062, paint);
    for (const double y : {kLabWidth - 0.26, kLabWidth - 0.34}) {
      pipe({0.1, y, 2.62}, {kLabLength - 0.1, y, 2.62}, 0.02, steel);
    }
  }

  // Over the wall and down to the benches, in straight pieces with round joints.
  void cables() {
    const std::int32_t rubber = matte(vec3(0.05F));
    const std::int32_t orange = matte(linear_from_srgb(214, 110, 40));
    cable({{1.2, kLabWidth - 0.02, 2.3},
           {1.8, kLabWidth - 0.02, 2.0},
           {2.1, kLabWidth - 0.02, 1.4},
           {2.2, kLabWidth - 0.05, 0.92}},
          0.012, rubber);
    cable({{2.6, kLabWidth - 0.02, 2.2},
           {2.7, kLabWidth - 0.02, 1.6},
           {3.1, kLabWidth - 0.02, 1.3},
           {3.6, kLabWidth - 0.06, 1.1}},
          0.01, orange);
    cable({{4.6, 1.9, 0.012}, {4.1, 1.6, 0.012}, {3.3, 1.75, 0.012}, {2.7, 1.5, 0.012}, {2.2, 1.0, 0.012}}, 0.014,
          orange);
    cable({{5.3, 0.05, 0.74}, {5.3, 0.02, 0.4}, {4.7, 0.02, 0.3}, {4.2, 0.02, 0.3}}, 0.01, rubber);
    const dvec3 hook(3.6, 2.5, kLabHeight - 0.001);  // a lamp hangs over the island
    cable({hook, hook - dvec3(0, 0, 0.5)}, 0.008, rubber);
    const std::int32_t shade = add(Pattern::bands, {dye(), dye(), dye()}, 0.08F);
    scene_.solids.emplace_back(Cylinder{hook - dvec3(0, 0, 0.68), 0.16, 0.18, shade, shade, shade});
  }

  void cable(const std::vector<dvec3>& course, double radius, std::int32_t material) {
    for (std::size_t i = 0; i + 1 < course.size(); ++i) {
      pipe(course[i], course[i + 1], radius, material);
      if (i > 0) sphere(course[i], 1.1 * radius, material);
    }
  }

  void pictures() {
    const std::int32_t frame =
        add(Pattern::wood, {linear_from_srgb(70, 52, 40), linear_from_srgb(40, 28, 20), vec3(0.1F)});
    hang({2.0, 0, 1.6}, {1.2, 0.85}, 3, poster(), frame);
    hang({5.6, 0, 1.75}, {1.3, 0.7}, 3, print_page(), frame);
    hang({kLabLength, 3.1, 1.9}, {1.0, 0.7}, 0, poster(), frame);
    hang({kLabLength, 0.5, 1.5}, {0.6, 0.9}, 0, print_page(), frame);
    hang({0, 0.9, 1.9}, {0.8, 0.6}, 1, print_page(), frame);
    hang({5.4, kLabWidth, 1.6}, {0.9, 1.1}, 2, poster(), frame);
    const std::int32_t mirror = add_metal(vec3(0.9F), 0);
    hang({3.7, 0, 1.35}, {0.9, 1.3}, 3, mirror, add_metal(vec3(0.5F), 0.1F));  // a polished plate
  }

  // Round the island, above the chairs.
  void make_walk() {
    scene_.walk = {{5.80, 2.50, 1.50}, {5.60, 3.55, 1.65}, {4.60, 3.80, 1.80}, {3.40, 3.75, 1.45},
                   {2.20, 3.75, 1.25}, {1.40, 3.40, 1.50}, {1.25, 2.50, 1.75}, {1.50, 1.55, 1.50},
                   {2.40, 1.35, 1.25}, {3.60, 1.35, 1.60}, {4.70, 1.35, 1.85}, {5.50, 1.60, 1.40}};
    scene_.flight = {{0.6, 0.8, 1.7}, {5.9, 0, 0}, {0, 3.6, 0}, {}};
    scene_.orbit = {{3.6, 2.5, 1.0}, {2.2, 1.2}, 1.6};
    scene_.stay = {{0.6, 0.9, 0.9}, {6.4, 4.2, 2.1}};
  }
};

}  // namespace

Scene make_lab(std::uint64_t seed, std::uint32_t triangles) {
  Scene scene = Lab(seed).furnished();
  scene.geometry = tessellate(scene.solids, edge_for_faces(scene.solids, triangles));
  return scene;
}

}  // namespace lumatlas::synth
