// SPDX-License-Identifier: GPL-3.0-or-later
// Geocentric coordinates against published ones, and georeferences out of range.
#include "atlas/earth_frame.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <glm/glm.hpp>
#include <limits>
#include <stdexcept>
#include <vector>

namespace lumatlas {
namespace {

constexpr double kPolarRadius = 6356752.314245;  // of WGS 84, metres

// The example of EPSG's Guidance Note 7-2 for methods 9602 and 9837: a point and an origin in the North Sea.
constexpr GeodeticPoint kEpsgPoint{53 + 48 / 60.0 + 33.820 / 3600, 2 + 7 / 60.0 + 46.380 / 3600, 73};
constexpr GeodeticPoint kEpsgOrigin{55, 5, 200};
const glm::dvec3 kEpsgPointAsPublished(3771793.968, 140253.342, 5124304.349);
const glm::dvec3 kEpsgOriginAsPublished(3652755.306, 319574.680, 5201547.353);
const glm::dvec3 kEpsgPointFromOriginAsPublished(-189013.869, -128642.040, -4220.171);

GeoReference reference_at(const GeodeticPoint& origin) {
  return {GeoReference::Frame::east_north_up, origin.latitude_deg, origin.longitude_deg, origin.altitude_m, {}};
}

glm::dvec3 on_earth(const GeoReference& reference, const glm::dvec3& point) {
  const auto motion = geocentric_from_scene(reference);
  REQUIRE(motion);
  return *motion * glm::dvec4(point, 1);
}

TEST_CASE("geocentric coordinates are as published, to a millimetre") {
  CHECK(glm::distance(geocentric_of(kEpsgPoint), kEpsgPointAsPublished) < 1e-3);
  CHECK(glm::distance(geocentric_of(kEpsgOrigin), kEpsgOriginAsPublished) < 1e-3);
  CHECK(glm::distance(on_earth(reference_at(kEpsgOrigin), kEpsgPointFromOriginAsPublished), kEpsgPointAsPublished) <
        2e-3);
}

TEST_CASE("equator, poles and antimeridian are where the axes of the ellipsoid end") {
  const double a = 6378137;
  CHECK(geocentric_of({0, 0, 0}) == glm::dvec3(a, 0, 0));
  CHECK(glm::distance(geocentric_of({0, 90, 10}), {0, a + 10, 0}) < 1e-6);
  for (const double longitude : {180.0, -180.0}) CHECK(geocentric_of({0, longitude, 0}) == glm::dvec3(-a, 0, 0));
  for (const double longitude : {0.0, 77.0, -180.0}) {
    CHECK(glm::distance(geocentric_of({90, longitude, 5}), {0, 0, kPolarRadius + 5}) < 1e-6);
    CHECK(glm::distance(geocentric_of({-90, longitude, 5}), {0, 0, -kPolarRadius - 5}) < 1e-6);
  }
}

TEST_CASE("east, north and up are at right angles, and point where latitude, longitude and altitude grow") {
  for (const GeodeticPoint& origin : std::vector<GeodeticPoint>{
           {0, 0, 0}, {48.2, -16.4, 190}, {-33.9, 151.2, 20}, {10, 180, 0}, {10, -180, 0}, {89.9, 30, 1}, {90, 0, 0}}) {
    CAPTURE(origin.latitude_deg, origin.longitude_deg);
    const glm::dmat4 motion = *geocentric_from_scene(reference_at(origin));
    CHECK(glm::determinant(glm::dmat3(motion)) == Approx(1).epsilon(1e-12));
    CHECK(glm::distance(glm::dvec3(motion * glm::dvec4(0, 0, 100, 1)),
                        geocentric_of({origin.latitude_deg, origin.longitude_deg, origin.altitude_m + 100})) < 1e-6);
    if (std::abs(origin.latitude_deg) > 89) continue;
    const GeodeticPoint east = geodetic_of(motion * glm::dvec4(1, 0, 0, 1));
    const GeodeticPoint north = geodetic_of(motion * glm::dvec4(0, 1, 0, 1));
    CHECK(std::remainder(east.longitude_deg - origin.longitude_deg, 360) > 8e-6);  // a metre is 9e-6 at the equator
    CHECK(east.latitude_deg == Approx(origin.latitude_deg).margin(1e-9));
    CHECK(north.latitude_deg - origin.latitude_deg == Approx(9e-6).margin(1e-7));
    CHECK(std::remainder(north.longitude_deg - origin.longitude_deg, 360) == Approx(0).margin(1e-9));
  }
}

TEST_CASE("geocentric coordinates become the same point again, from below the sea to beyond satellites") {
  for (const double altitude : {-1e5, -11'000.0, 0.0, 8849.0, 4e5, 3.6e7}) {
    for (const double latitude : {-90.0, -89.999, -45.0, -1e-7, 0.0, 30.0, 55.5, 89.9999, 90.0}) {
      for (const double longitude : {-180.0, -179.999, -0.001, 0.0, 90.0, 179.5}) {
        CAPTURE(latitude, longitude, altitude);
        const glm::dvec3 there = geocentric_of({latitude, longitude, altitude});
        const GeodeticPoint back = geodetic_of(there);
        CHECK(glm::distance(geocentric_of(back), there) < 1e-6);
        CHECK(back.altitude_m == Approx(altitude).margin(1e-6));
        CHECK(back.latitude_deg == Approx(latitude).margin(1e-10));
      }
    }
  }
}

TEST_CASE("geocentric scenes stay where they are, unless their ellipsoid is another") {
  const auto motion = [](const std::string& system) {
    return geocentric_from_scene({GeoReference::Frame::geocentric, 0, 0, 0, system});
  };
  CHECK(motion("") == glm::dmat4(1));
  CHECK(motion(R"(GEOGCS["WGS 84"])") == glm::dmat4(1));
  CHECK(motion(R"(GEOGCS["WGS 84",DATUM["D",SPHEROID["WGS 84",6378137,298.257223563]]])") == glm::dmat4(1));
  CHECK(motion(R"(GEODCRS["ETRS89",DATUM["D",ELLIPSOID["GRS 1980",6378137.0,298.257222101]]])") == glm::dmat4(1));
  CHECK_FALSE(motion(R"(GEOGCS["DHDN",DATUM["D",SPHEROID["Bessel 1841",6377397.155,299.1528128]]])"));
}

TEST_CASE("a georeference beyond the Earth is refused by its field") {
  const auto sentence = [](double latitude, double longitude, double altitude) -> std::string {
    try {
      check({GeoReference::Frame::east_north_up, latitude, longitude, altitude, {}});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  CHECK(sentence(90, -180, -1e7) == "accepted");
  CHECK(sentence(90.5, 0, 0) == "georeference: latitude is 90.5, must be within 90 of 0");
  CHECK(sentence(0, 181, 0) == "georeference: longitude is 181, must be within 180 of 0");
  CHECK(sentence(0, 0, 2e7) == "georeference: altitude is 20000000, must be within 10000000 of 0");
  CHECK(sentence(std::numeric_limits<double>::quiet_NaN(), 0, 0) ==
        "georeference: latitude is nan, must be within 90 of 0");
}

}  // namespace
}  // namespace lumatlas
