// SPDX-License-Identifier: GPL-3.0-or-later
// The apartment: a living room (x in [0, 5.2]) and a bedroom (x in [5.35, 8.6]), joined by a doorway.
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

constexpr double kCeiling = 2.6;

enum Room : std::size_t { kLiving, kBedroom, kDoorway, kNorthWindow, kEastWindow, kRoomCount };

class Apartment : private Furnisher {
 public:
  explicit Apartment(std::uint64_t seed)
      : Furnisher(hashed(seed, 0x61706172)), mirror_random_(hashed(seed, 0x6d6972726f72)) {}

  Scene furnished() {
    make_rooms();
    make_lights();
    make_living_room();
    make_bedroom();
    hang_mirror();  // last, with random numbers of its own: the rest of the apartment is as it would be without
    make_walk();
    scene_.flight = {{0, 0, 1.7}, {8.6, 0, 0}, {0, 4.2, 0}, {}};
    scene_.orbit = {{4.3, 2.1, 1.0}, {3.5, 1.4}, 1.6};
    scene_.stay = {{0.3, 0.3, 0.9}, {8.3, 3.9, 2.2}};
    return std::move(scene_);
  }

 private:
  // ---- The rooms.

  void make_rooms() {
    const std::int32_t ceiling = add(Pattern::plaster, {tone(228, 226, 220), vec3(0.5F), vec3(0.3F)});
    const std::int32_t living_wall =
        add(Pattern::wallpaper, {tone(214, 202, 176), tone(196, 188, 160), dye() * 0.6F}, 0.24F);
    const std::int32_t accent_wall = add(Pattern::plaster, {tone(150, 176, 180), vec3(0.5F), vec3(0.3F)});
    const std::int32_t bed_wall =
        add(Pattern::wallpaper, {tone(180, 196, 214), tone(208, 210, 220), dye() * 0.6F}, 0.3F);
    const std::int32_t parquet = add_glossy(
        Pattern::parquet, {linear_from_srgb(190, 140, 88), linear_from_srgb(128, 82, 46), linear_from_srgb(40, 24, 14)},
        0.13F, 0.1F);
    const std::int32_t tile = add_glossy(
        Pattern::tiles, {linear_from_srgb(206, 200, 190), linear_from_srgb(120, 132, 140), dye() * 0.7F}, 0.36F, 0.1F);
    const std::int32_t jamb =
        add(Pattern::wood, {linear_from_srgb(222, 214, 200), linear_from_srgb(196, 184, 164), vec3(0.1F)});
    std::vector<BlockPart> air(kRoomCount);
    air[kLiving] = {
        {0, 0, 0}, {5.2, 4.2, kCeiling}, {living_wall, living_wall, accent_wall, living_wall, parquet, ceiling}};
    air[kBedroom] = {{5.35, 0, 0}, {8.6, 4.2, kCeiling}, {bed_wall, bed_wall, accent_wall, bed_wall, tile, ceiling}};
    air[kDoorway] = {{5.2, 1.6, 0}, {5.35, 2.6, 2.1}, {jamb, jamb, jamb, jamb, jamb, jamb}};
    air[kNorthWindow] = {{2.5, 4.2, 0.95}, {4.1, 4.4, 2.15}, {jamb, jamb, jamb, view_outside(), jamb, jamb}};
    air[kEastWindow] = {{8.6, 1.6, 0.95}, {8.8, 2.9, 2.15}, {jamb, view_outside(), jamb, jamb, jamb, jamb}};
    scene_.solids.emplace_back(Block{{}, 0, air, true});
  }

  std::int32_t view_outside() {
    return add_emission(Pattern::sky, linear_from_srgb(120, 168, 226), linear_from_srgb(236, 238, 240), 1.15F);
  }

  void make_lights() {
    const vec3 warm(1.0F, 0.86F, 0.68F);
    const vec3 day(0.72F, 0.86F, 1.0F);
    ceiling_panel({2.5, 2.0}, {1.1, 0.7}, kCeiling, kLampRadiance * warm);
    ceiling_panel({7.0, 2.1}, {0.8, 0.6}, kCeiling, kLampRadiance * warm);
    scene_.lights.push_back({{2.5F, 4.36F, 0.95F}, {1.6F, 0, 0}, {0, 0, 1.2F}, 3.6F * day});   // shines towards -y
    scene_.lights.push_back({{8.76F, 2.9F, 0.95F}, {0, -1.3F, 0}, {0, 0, 1.2F}, 4.0F * day});  // shines towards -x
    scene_.ambient_above = {0.18F, 0.18F, 0.19F};
    scene_.ambient_below = {0.34F, 0.29F, 0.24F};
    const std::int32_t bars =
        add(Pattern::wood, {linear_from_srgb(230, 226, 216), linear_from_srgb(206, 198, 184), vec3(0.1F)});
    box({3.3, 4.33}, 0.95, {0.05, 0.04, 1.2 + kSink}, bars).parts[0].material[5] = kOpen;
    box({8.73, 2.25}, 0.95, {0.04, 0.05, 1.2 + kSink}, bars).parts[0].material[5] = kOpen;
  }

  // ---- The living room.

  void make_living_room() {
    sofa({2.4, 0.46});
    coffee_table({2.4 + random_.uniform(-0.1, 0.1), 2.1});
    bookshelf({0.19, 3.2});
    window_cabinet({3.3, 3.96});
    floor_lamp({0.42, 0.42});
    corner_table({4.5, 0.55});
    toy_blocks({4.0, 1.3});
    const std::int32_t frame =
        add(Pattern::wood, {linear_from_srgb(70, 52, 40), linear_from_srgb(40, 28, 20), vec3(0.1F)});
    hang({2.4, 0, 1.62}, {1.5, 0.8}, 3, poster(), frame);
    hang({0, 1.45, 1.5}, {0.8, 1.1}, 1, print_page(), frame);
    hang({5.2, 0.8, 1.55}, {0.7, 1.0}, 0, poster(), frame);
    hang({5.2, 3.45, 1.5}, {1.1, 0.8}, 0, print_page(), frame);
    hang({1.3, 4.2, 1.55}, {0.9, 0.7}, 2, poster(), frame);
  }

  void sofa(dvec2 at) {
    const std::int32_t cloth = add(Pattern::fabric, {dye(), dye(), dye()});
    const std::int32_t cushion = add(Pattern::rug, {dye(), dye(), dye()}, 0.16F);
    box(at, 0, {2.0, 0.84, 0.4}, cloth);
    box(at + dvec2(0, -0.3), 0.4, {2.0, 0.22, 0.45}, cloth);
    for (const double side : {-1.0, 1.0}) {
      box(at + dvec2(side * 1.08, 0), 0, {0.18, 0.86, 0.6}, cloth);
      box(at + dvec2(side * 0.48, 0.08), 0.4, {0.9, 0.5, 0.12}, cloth);
      box(at + dvec2(side * 0.7, -0.05), 0.52, {0.4, 0.14, 0.38}, cushion, side * random_.uniform(0.1, 0.35));
    }
  }

  void coffee_table(dvec2 at) {
    const std::int32_t top = oak();
    const std::int32_t carpet = add(Pattern::rug, {dye(), dye(), dye() * 0.5F}, 0.3F);
    box(at, 0, {2.3, 1.5, 0.015}, carpet);
    board(at, 0.42, {1.2, 0.66, 0.05}, top);
    legs(at, {1.2, 0.66}, 0.42, 0.06, top);
    sphere(dvec3(at + dvec2(0.34, 0.04), 0.47 + 0.15 - kSink), 0.15, add_metal({0.95F, 0.76F, 0.42F}, 0.02F));
    const std::int32_t glaze = add_glossy(Pattern::bands, {dye(), dye(), dye()}, 0.07F, 0.05F);
    cylinder(at + dvec2(-0.42, 0.14), 0.47, 0.08, 0.24, glaze, matte(vec3(0.02F)));
    for (int i = 0; i < 3; ++i) {
      book_lying(at + dvec2(-0.05, -0.08), 0.47 + 0.035 * i, random_.uniform(-0.5, 0.5));
    }
  }

  void bookshelf(dvec2 at) {
    const std::int32_t wood = oak();
    const double width = 1.5;
    const double depth = 0.32;
    const double height = 2.0;
    for (const double side : {-0.5, 0.5}) box(at + dvec2(0, side * width), 0, {depth, 0.04, height}, wood);
    board(at - dvec2(0.5 * depth - 0.01, 0), 0.02, {0.02, width - 0.02, height - 0.05}, wood);
    const double pitch = (height - 0.06) / 5;
    for (int shelf = 0; shelf <= 5; ++shelf) {
      const double z = 0.03 + pitch * shelf - (shelf == 5 ? 0.01 : 0);
      board(at, z, {depth - 0.004, width - 0.02, 0.03}, wood);
      if (shelf < 5) fill_shelf(at, z + 0.03, 0.5 * width - 0.03, pitch - 0.06);
    }
  }

  void window_cabinet(dvec2 at) {
    const std::int32_t wood = oak();
    Block& body = box(at, 0, {1.9, 0.44, 0.6}, wood);
    body.parts[0].material[2] = add(Pattern::tiles, {dye(), dye(), dye()}, 0.2F);
    const std::int32_t earth = add(Pattern::globe, {linear_from_srgb(52, 96, 168), linear_from_srgb(96, 140, 66),
                                                    linear_from_srgb(206, 178, 120)});
    cylinder(at + dvec2(-0.6, 0), 0.6, 0.09, 0.03, wood, wood);
    sphere(dvec3(at + dvec2(-0.6, 0), 0.63 + 0.16 - kSink), 0.16, earth);
    const std::int32_t glaze = add_glossy(Pattern::bands, {dye(), dye(), dye()}, 0.05F, 0.05F);
    cylinder(at + dvec2(0.15, 0.03), 0.6, 0.06, 0.2, glaze, glaze);
    box(at + dvec2(0.6, 0), 0.6, {0.3, 0.2, 0.18}, add(Pattern::letter, {dye(), dye(), dye() * 0.2F}), 0.3);
  }

  void floor_lamp(dvec2 at) {
    const std::int32_t steel = add_metal(vec3(0.6F, 0.6F, 0.62F), 0.1F);
    const std::int32_t shade =
        add(Pattern::bands, {linear_from_srgb(236, 220, 180), linear_from_srgb(200, 150, 110), dye()}, 0.12F);
    cylinder(at, 0, 0.16, 0.03, steel, steel);
    cylinder(at, 0.03, 0.018, 1.5, steel, steel);
    scene_.solids.emplace_back(Cylinder{dvec3(at, 1.4), 0.2, 0.32, shade, shade, shade});
  }

  void corner_table(dvec2 at) {
    const std::int32_t wood = oak();
    cylinder(at, 0, 0.05, 0.55, wood, kOpen);
    scene_.solids.emplace_back(Cylinder{dvec3(at, 0.54), 0.34, 0.04, wood, wood, wood});
    const std::int32_t copper = add_metal({0.93F, 0.6F, 0.48F}, 0.06F);
    cylinder(at + dvec2(0.05, 0.03), 0.58, 0.09, 0.16, copper, matte(vec3(0.03F)));
    book_lying(at + dvec2(-0.17, -0.12), 0.58, 0.7);
  }

  void toy_blocks(dvec2 at) {
    for (int i = 0; i < 6; ++i) {
      const int column = i % 3;
      const int row = i / 3;
      const double side = random_.uniform(0.13, 0.2);
      const double shift = random_.uniform(-0.03, 0.03);
      const dvec2 place = at + dvec2(0.32 * column + shift, 0.34 * row + random_.uniform(-0.03, 0.03));
      toy_block(place, 0, side, random_.uniform(0, 0.5 * std::numbers::pi));
      if (i == 1 || i == 3) toy_block(place, side, 0.12, random_.uniform(0, 0.5 * std::numbers::pi));
    }
  }

  void toy_block(dvec2 at, double bottom, double side, double yaw) {
    Block& block = box(at, bottom, dvec3(side), 0, yaw);
    for (const int face : {0, 1, 2, 3, 5}) {
      block.parts[0].material[face] = add(Pattern::letter, {dye() * 0.4F + 0.4F, dye(), dye() * 0.25F});
    }
  }

  // ---- The bedroom.

  void make_bedroom() {
    bed({7.5, 1.02});
    wardrobe({5.66, 3.55});
    desk({7.4, 3.85});
    round_rug({7.1, 2.75});
    const std::int32_t steel = add_metal(vec3(0.75F, 0.78F, 0.82F), 0.05F);
    cylinder({8.3, 3.85}, 0, 0.14, 0.75, steel, matte(vec3(0.02F)));
    const std::int32_t frame =
        add(Pattern::wood, {linear_from_srgb(210, 200, 180), linear_from_srgb(180, 166, 140), vec3(0.1F)});
    hang({7.5, 0, 1.65}, {1.2, 0.8}, 3, poster(), frame);
    hang({5.35, 0.8, 1.5}, {0.8, 1.0}, 1, print_page(), frame);
    hang({7.4, 4.2, 1.75}, {1.1, 0.55}, 2, poster(), frame);
    hang({8.6, 0.8, 1.5}, {0.7, 0.9}, 0, poster(), frame);
  }

  // Beside the east window, as tall as a head and shoulders; nothing else is without any roughness.
  void hang_mirror() {
    const double width = mirror_random_.uniform(0.45, 0.6);
    const double height = mirror_random_.uniform(0.8, 1.0);
    const std::int32_t mirror = add_metal(vec3(0.9F), 0);
    hang({8.6, 3.5, 1.45}, {width, height}, 0, mirror, add_metal({0.9F, 0.75F, 0.5F}, 0.1F));
  }

  void bed(dvec2 at) {
    const std::int32_t wood = oak();
    const std::int32_t cover = add(Pattern::fabric, {dye(), dye(), dye()}, 1.6F);
    const std::int32_t pillow = add(Pattern::fabric, {vec3(0.75F), dye() * 0.5F + 0.4F, vec3(0.6F)}, 0.8F);
    box(at, 0, {1.5, 1.96, 0.3}, wood);
    box(at + dvec2(0, 0.02), 0.3, {1.42, 1.88, 0.18}, cover);
    box(at + dvec2(0, -0.96), 0, {1.5, 0.06, 0.95}, wood);
    for (const double side : {-0.36, 0.36}) box(at + dvec2(side, -0.68), 0.48, {0.6, 0.36, 0.12}, pillow, 0.15 * side);
    const std::int32_t chest = add(Pattern::letter, {dye(), dye(), dye() * 0.2F});
    box(at + dvec2(-1.05, -0.76), 0, {0.42, 0.4, 0.5}, chest);
  }

  void wardrobe(dvec2 at) {
    const std::int32_t wood = oak();
    Block& body = box(at, 0, {0.56, 1.2, 2.1}, wood);
    body.parts[0].material[0] = kOpen;
    body.origin.x -= 0.04;  // its back is in the wall
    const std::int32_t knob = add_metal({0.95F, 0.8F, 0.5F}, 0.05F);
    for (const double side : {-0.3, 0.3}) {
      const std::int32_t panel = add(Pattern::wood, {dye() * 0.5F + 0.2F, dye() * 0.3F + 0.1F, vec3(0.1F)}, 1.5F);
      board(at + dvec2(0.24, side), 0.12, {0.03, 0.5, 1.85}, panel);
      sphere(dvec3(at + dvec2(0.275, 0.2 * side), 1.05), 0.03, knob);
    }
  }

  void desk(dvec2 at) {
    const std::int32_t wood = oak();
    const std::int32_t dark = add_glossy(Pattern::plain, {vec3(0.03F), vec3(0.03F), vec3(0.03F)}, 1, 0.05F);
    board(at, 0.7, {1.4, 0.62, 0.04}, wood);
    legs(at, {1.4, 0.62}, 0.7, 0.05, wood);
    const std::int32_t picture = add_glossy(Pattern::screen, {dye(), dye(), dye() * 0.5F + 0.4F}, 1, 0.05F);
    box(at + dvec2(-0.1, 0.12), 0.74, {0.26, 0.18, 0.015}, dark);
    box(at + dvec2(-0.1, 0.16), 0.755, {0.06, 0.04, 0.12}, dark);
    board(at + dvec2(-0.1, 0.1), 0.85, {0.66, 0.04, 0.4}, dark).parts[0].material[2] = picture;
    box(at + dvec2(-0.08, -0.16), 0.74, {0.42, 0.14, 0.02},
        add(Pattern::print, {vec3(0.08F), vec3(0.1F), vec3(0.02F)}, 0.035F));
    cylinder(at + dvec2(0.45, -0.1), 0.74, 0.045, 0.1, add(Pattern::bands, {dye(), dye(), dye()}, 0.04F), dark);
    chair(at + dvec2(0.1, -0.6), random_.uniform(0.15, 0.5));
  }

  void round_rug(dvec2 at) {
    const std::int32_t carpet = add(Pattern::rug, {dye(), dye(), dye() * 0.5F}, 0.22F);
    cylinder(at, 0, 0.6, 0.015, carpet, carpet);
  }

  // Round the living room, through the door, round the bedroom and back; above all furniture that it passes over.
  void make_walk() {
    scene_.walk = {{4.75, 2.1, 1.50},  {4.30, 1.75, 1.65}, {3.60, 1.35, 1.80}, {2.40, 1.25, 1.45}, {1.20, 1.30, 1.15},
                   {0.85, 2.00, 1.35}, {1.00, 2.75, 1.70}, {2.00, 3.05, 1.90}, {3.30, 3.00, 1.55}, {4.30, 2.55, 1.20},
                   {4.75, 2.10, 1.30}, {5.20, 2.10, 1.45}, {5.70, 2.10, 1.55}, {6.20, 1.90, 1.70}, {6.25, 1.30, 1.50},
                   {6.40, 1.50, 1.25}, {7.00, 2.20, 1.40}, {8.00, 2.30, 1.75}, {8.05, 2.80, 1.90}, {7.20, 2.75, 1.60},
                   {6.40, 2.50, 1.25}, {5.80, 2.10, 1.20}, {5.25, 2.10, 1.35}};
  }

  Random mirror_random_;
};

}  // namespace

Scene make_apartment(std::uint64_t seed, std::uint32_t triangles) {
  Scene scene = Apartment(seed).furnished();
  scene.geometry = tessellate(scene.solids, edge_for_faces(scene.solids, triangles));
  return scene;
}

}  // namespace lumatlas::synth
