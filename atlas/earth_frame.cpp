// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/earth_frame.h"

#include <cmath>
#include <glm/trigonometric.hpp>
#include <stdexcept>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

constexpr double kEquatorRadius = 6378137;         // WGS 84, metres
constexpr double kFlattening = 1 / 298.257223563;  // WGS 84

constexpr double kSquaredEccentricity = kFlattening * (2 - kFlattening);

// Sine and cosine of an angle, exact where the angle is a whole number of quarter turns.
struct Turn {
  double sine, cosine;

  explicit Turn(double degrees) : sine(std::sin(glm::radians(degrees))), cosine(std::cos(glm::radians(degrees))) {
    if (std::abs(degrees) == 90) cosine = 0;
    if (std::abs(degrees) == 180) sine = 0;
  }
};

// Returns the distance from the surface along its normal to the axis of the poles.
double normal_radius(double sine_of_latitude) {
  return kEquatorRadius / std::sqrt(1 - kSquaredEccentricity * sine_of_latitude * sine_of_latitude);
}

// Returns whether a system in WKT names an ellipsoid of another radius: SPHEROID["Bessel 1841",6377397.155,...].
bool has_other_ellipsoid(const std::string& system) {
  for (const char* const keyword : {"SPHEROID[", "ELLIPSOID["}) {
    const std::size_t found = system.find(keyword);
    if (found == std::string::npos) continue;
    return system.find(",6378137", found) == std::string::npos;
  }
  return false;
}

void require_within(double value, double most, const char* field) {
  if (std::abs(value) <= most) return;
  throw std::invalid_argument("georeference: " + std::string(field) + " is " + number_text(value) +
                              ", must be within " + number_text(most) + " of 0");
}

}  // namespace

void check(const GeoReference& reference) {
  require_within(reference.latitude_deg, 90, "latitude");
  require_within(reference.longitude_deg, 180, "longitude");
  require_within(reference.altitude_m, kMostAltitude, "altitude");
}

glm::dvec3 geocentric_of(const GeodeticPoint& point) {
  const Turn latitude(point.latitude_deg), longitude(point.longitude_deg);
  const double normal = normal_radius(latitude.sine), from_axis = (normal + point.altitude_m) * latitude.cosine;
  return {from_axis * longitude.cosine, from_axis * longitude.sine,
          ((1 - kSquaredEccentricity) * normal + point.altitude_m) * latitude.sine};
}

GeodeticPoint geodetic_of(const glm::dvec3& geocentric) {
  constexpr int kSteps = 10;  // each makes the error some 150 times smaller
  const double from_axis = std::hypot(geocentric.x, geocentric.y);
  double latitude = std::atan2(geocentric.z, (1 - kSquaredEccentricity) * from_axis);
  for (int step = 0; step < kSteps; ++step) {
    const double sine = std::sin(latitude);
    latitude = std::atan2(geocentric.z + kSquaredEccentricity * normal_radius(sine) * sine, from_axis);
  }
  const double sine = std::sin(latitude);
  const double altitude =
      from_axis * std::cos(latitude) + geocentric.z * sine - kEquatorRadius * kEquatorRadius / normal_radius(sine);
  const double longitude = from_axis > 0 ? std::atan2(geocentric.y, geocentric.x) : 0;
  return {glm::degrees(latitude), glm::degrees(longitude), altitude};
}

std::optional<glm::dmat4> geocentric_from_scene(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    if (has_other_ellipsoid(reference.system)) return std::nullopt;
    return glm::dmat4(1);
  }
  const Turn latitude(reference.latitude_deg), longitude(reference.longitude_deg);
  const glm::dvec3 east(-longitude.sine, longitude.cosine, 0);
  const glm::dvec3 north(-latitude.sine * longitude.cosine, -latitude.sine * longitude.sine, latitude.cosine);
  const glm::dvec3 up(latitude.cosine * longitude.cosine, latitude.cosine * longitude.sine, latitude.sine);
  const glm::dvec3 origin = geocentric_of({reference.latitude_deg, reference.longitude_deg, reference.altitude_m});
  return glm::dmat4(glm::dvec4(east, 0), glm::dvec4(north, 0), glm::dvec4(up, 0), glm::dvec4(origin, 1));
}

}  // namespace lumatlas
