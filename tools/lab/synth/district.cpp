// SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <glm/glm.hpp>
#include <type_traits>
#include <utility>
#include <variant>

#include "tools/lab/synth/random.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas::synth {
namespace {

using glm::dvec2;
using glm::dvec3;

constexpr double kStreetOffset = 11;  // distance of a village's streets from its middle
constexpr double kEyeHeight = 1.7;
constexpr double kStride = 2.75;  // between control points of the walk

void renumber(std::int32_t& material, std::int32_t first) {
  if (material != kOpen) material += first;
}

// Moves a solid, and counts its materials on from `first`.
void place(Solid& solid, const dvec3& shift, std::int32_t first) {
  std::visit(
      [&](auto& body) {
        using Body = std::decay_t<decltype(body)>;
        if constexpr (std::is_same_v<Body, Block>) {
          body.origin += shift;
          for (BlockPart& part : body.parts) {
            for (std::int32_t& material : part.material) renumber(material, first);
          }
        } else if constexpr (std::is_same_v<Body, Cylinder>) {
          body.base += shift;
          for (std::int32_t* material : {&body.side, &body.bottom, &body.top}) renumber(*material, first);
        } else if constexpr (std::is_same_v<Body, Sphere>) {
          body.center += shift;
          renumber(body.material, first);
        } else {
          body.origin += shift;
          for (ConvexSide& side : body.sides) renumber(side.material, first);
        }
      },
      solid);
}

// Adds a village, whose air joins the district's.
void add_village(Scene village, const dvec3& shift, Scene& district) {
  const auto first = static_cast<std::int32_t>(district.materials.size());
  district.materials.insert(district.materials.end(), village.materials.begin(), village.materials.end());
  auto& air = std::get<Block>(district.solids.front());
  for (BlockPart part : std::get<Block>(village.solids.front()).parts) {
    part.min += shift;
    part.max += shift;
    for (std::int32_t& material : part.material) renumber(material, first);
    air.parts.push_back(part);
  }
  for (std::size_t i = 1; i < village.solids.size(); ++i) {
    place(village.solids[i], shift, first);
    district.solids.push_back(std::move(village.solids[i]));
  }
}

// Along the streets that run along x, to and fro, from one to the next by a street along y, and back by the first one.
std::vector<dvec3> walk_along_streets(const dvec2& low, std::uint32_t columns, std::uint32_t rows) {
  const auto street = [](double first, std::uint32_t number) {
    const std::uint32_t village = number / 2;
    const double middle = first + kVillageSide * village;
    return middle + (number % 2 == 0 ? -kStreetOffset : kStreetOffset);
  };
  std::vector<dvec2> corners;
  for (std::uint32_t row = 0; row < 2 * rows; ++row) {
    const double west = street(low.x, 0), east = street(low.x, 2 * columns - 1), y = street(low.y, row);
    corners.emplace_back(row % 2 == 0 ? west : east, y);
    corners.emplace_back(row % 2 == 0 ? east : west, y);
  }
  std::vector<dvec3> walk;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const dvec2 from = corners[i], to = corners[(i + 1) % corners.size()];
    const int count = static_cast<int>(std::round(glm::distance(from, to) / kStride));
    for (int step = 0; step < count; ++step) {
      walk.emplace_back(glm::mix(from, to, static_cast<double>(step) / count), kEyeHeight);
    }
  }
  return walk;
}

// Extends the ways through one village over all of them, whose middles begin at `low`.
void extend_ways(const dvec2& low, std::uint32_t columns, std::uint32_t rows, Scene& district) {
  const dvec2 times(columns, rows), beyond = 0.5 * kVillageSide * (times - 1.0);
  const dvec2 flight(district.flight.along.x, district.flight.aside.y);
  district.walk = walk_along_streets(low, columns, rows);
  district.walk_gaze.swings *= times.x * times.y;
  district.walk_gaze.nods *= times.x * times.y;
  district.flight.corner -= dvec3(beyond, 0);
  district.flight.along.x = flight.x + 2 * beyond.x;
  district.flight.aside.y = flight.y + 2 * beyond.y;
  district.flight.gaze.swings *= times.x * times.y;
  district.flight.gaze.nods *= times.x * times.y;
  district.orbit.radii += beyond;
  district.stay.low -= dvec3(beyond, 0);
  district.stay.high += dvec3(beyond, 0);
}

}  // namespace

Scene make_district(std::uint64_t seed, std::uint32_t triangles, std::uint32_t columns, std::uint32_t rows) {
  if (columns == 1 && rows == 1) return make_village(seed, triangles);
  const dvec2 low = -0.5 * kVillageSide * (dvec2(columns, rows) - 1.0);
  Scene district = untessellated_village(hashed(seed, 0));  // its light, sky and ways
  Block air;
  air.hollow = true;
  district.solids.assign(1, air);
  district.materials.clear();
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint64_t number = row * std::uint64_t{columns} + column;
      const dvec2 middle = low + kVillageSide * dvec2(column, row);
      add_village(untessellated_village(hashed(seed, number)), dvec3(middle, 0), district);
    }
  }
  extend_ways(low, columns, rows, district);
  district.geometry = tessellate(district.solids, edge_for_faces(district.solids, triangles));
  return district;
}

}  // namespace lumatlas::synth
