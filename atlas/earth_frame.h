// SPDX-License-Identifier: GPL-3.0-or-later
// The place of a scene's coordinates on the Earth, by the ellipsoid of WGS 84. Geocentric coordinates are metres from
// the Earth's centre, x to latitude and longitude 0, z to the north pole (EPSG:4978).
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>

namespace lumatlas {

// The georeference of a scene: the meaning of its coordinates before an offset is subtracted.
struct GeoReference {
  enum class Frame {
    east_north_up,  // metres east, north and up of the origin below
    geocentric,     // geocentric coordinates, metres
  };
  Frame frame = Frame::east_north_up;
  double latitude_deg = 0;   // the origin's, WGS 84, [-90, 90]
  double longitude_deg = 0;  // [-180, 180]
  double altitude_m = 0;     // above the ellipsoid, as far as the form says so; within kMostAltitude of 0
  std::string system = {};   // for Frame::geocentric: the coordinate reference system, as the form names it (WKT)

  friend bool operator==(const GeoReference&, const GeoReference&) = default;
};

inline constexpr double kMostAltitude = 1e7;  // metres

// Throws std::invalid_argument naming the field, its value and its range.
void check(const GeoReference& reference);

// A point by angles and its height above the ellipsoid.
struct GeodeticPoint {
  double latitude_deg = 0, longitude_deg = 0, altitude_m = 0;
};

// Returns the geocentric coordinates of a point.
[[nodiscard]] glm::dvec3 geocentric_of(const GeodeticPoint& point);

// Returns the point of geocentric coordinates, exact to a micrometre from 100 km below the ellipsoid up. The longitude
// of a pole is 0.
[[nodiscard]] GeodeticPoint geodetic_of(const glm::dvec3& geocentric);

// Returns the rigid motion from the scene's coordinates to geocentric ones. None: the reference's system is geocentric
// and names an ellipsoid of another radius, whose centre may lie hundreds of metres away. Systems with the radius of
// WGS 84, such as ETRS89 and NAD83, count as WGS 84: they agree within two metres. So does a system that names none.
[[nodiscard]] std::optional<glm::dmat4> geocentric_from_scene(const GeoReference& reference);

}  // namespace lumatlas
