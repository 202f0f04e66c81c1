// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/geo_reference.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

using nlohmann::json;

namespace {

constexpr const char* kEastNorthUp = "east-north-up";
constexpr const char* kGeocentric = "geocentric";

std::optional<double> number_in(const json& object, const char* key, double most) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::abs(value) <= most ? std::optional(value) : std::nullopt;
}

}  // namespace

json json_of(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    return {{"frame", kGeocentric}, {"system", reference.system}};
  }
  return {{"frame", kEastNorthUp},
          {"latitude", reference.latitude_deg},
          {"longitude", reference.longitude_deg},
          {"altitude", reference.altitude_m}};
}

std::optional<GeoReference> geo_reference_of(const json& value) {
  if (!value.is_object() || !value.contains("frame")) return std::nullopt;
  if (value["frame"] == kGeocentric) {
    const json system = value.value("system", json());
    if (!system.is_string()) return std::nullopt;
    return GeoReference{GeoReference::Frame::geocentric, 0, 0, 0, system.get<std::string>()};
  }
  const auto latitude = number_in(value, "latitude", 90), longitude = number_in(value, "longitude", 180),
             altitude = number_in(value, "altitude", 1e12);
  if (value["frame"] != kEastNorthUp || !latitude || !longitude || !altitude) return std::nullopt;
  return GeoReference{GeoReference::Frame::east_north_up, *latitude, *longitude, *altitude, {}};
}

std::string text_of(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    return "metres from the Earth's centre (geocentric), of the reference system " + short_reason(reference.system);
  }
  return "metres east, north and up of latitude " + number_text(reference.latitude_deg) + ", longitude " +
         number_text(reference.longitude_deg) + " and altitude " + number_text(reference.altitude_m) + " (WGS 84)";
}

}  // namespace lumatlas
