// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/geo_reference.h"

#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

using nlohmann::json;

namespace {

namespace fs = std::filesystem;

constexpr const char* kEastNorthUp = "east-north-up";
constexpr const char* kGeocentric = "geocentric";

std::optional<double> number_in(const json& object, const char* key, double most) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return std::nullopt;
  const double value = found->get<double>();
  return std::abs(value) <= most ? std::optional(value) : std::nullopt;
}

[[noreturn]] void refuse_reference(std::string_view text, const std::string& why) {
  throw std::invalid_argument(std::string(text) + " " + why +
                              ": give latitude and longitude of the scene's origin in degrees and its altitude in "
                              "metres, such as 48.2,-16.4,190, or geocentric");
}

// Returns the parts between commas, without spaces and parentheses around them.
std::vector<std::string> parts_of_reference(std::string_view text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else if (std::isspace(static_cast<unsigned char>(c)) == 0 && c != '(' && c != ')') {
      parts.back() += c;
    }
  }
  return parts;
}

}  // namespace

std::optional<fs::path> reference_file_beside(const fs::path& scene) {
  for (const fs::path& folder : {scene, scene / "opensfm"}) {
    std::error_code ignored;
    if (fs::is_regular_file(folder / kReferenceFile, ignored)) return folder / kReferenceFile;
  }
  return std::nullopt;
}

std::optional<GeoReference> reference_beside(const fs::path& scene) {
  const std::optional<fs::path> file = reference_file_beside(scene);
  if (!file) return std::nullopt;
  const json document = read_json(*file);
  const JsonPlace place(file->string(), "", document);
  GeoReference reference;
  reference.latitude_deg = place.at("latitude").number();
  reference.longitude_deg = place.at("longitude").number();
  reference.altitude_m = place.has("altitude") ? place.at("altitude").number() : 0;
  try {
    check(reference);
  } catch (const std::invalid_argument& error) {
    place.refuse(error.what());
  }
  if (reference.latitude_deg == 0 && reference.longitude_deg == 0) return std::nullopt;
  return reference;
}

GeoReference parse_geo_reference(std::string_view text) {
  GeoReference reference;
  if (text == kGeocentric) {
    reference.frame = GeoReference::Frame::geocentric;
    return reference;
  }
  const std::vector<std::string> parts = parts_of_reference(text);
  const std::array<double*, 3> fields{&reference.latitude_deg, &reference.longitude_deg, &reference.altitude_m};
  if (parts.size() != fields.size()) refuse_reference(text, "is not three numbers");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const char* const end = parts[i].data() + parts[i].size();
    const auto [stop, error] = std::from_chars(parts[i].data(), end, *fields[i]);
    if (error != std::errc() || stop != end) refuse_reference(text, "is not three numbers");
  }
  if (!(std::abs(reference.latitude_deg) <= 90)) refuse_reference(text, "has a latitude beyond 90 degrees");
  if (!(std::abs(reference.longitude_deg) <= 180)) refuse_reference(text, "has a longitude beyond 180 degrees");
  if (!(std::abs(reference.altitude_m) <= kMostAltitude)) {
    refuse_reference(text, "has an altitude beyond " + number_text(kMostAltitude) + " metres");
  }
  return reference;
}

json json_of(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    json geocentric{{"frame", kGeocentric}};
    if (!reference.system.empty()) geocentric["system"] = reference.system;
    return geocentric;
  }
  return {{"frame", kEastNorthUp},
          {"latitude", reference.latitude_deg},
          {"longitude", reference.longitude_deg},
          {"altitude", reference.altitude_m}};
}

std::optional<GeoReference> geo_reference_of(const json& value) {
  if (!value.is_object() || !value.contains("frame")) return std::nullopt;
  if (value["frame"] == kGeocentric) {
    const json system = value.value("system", json(""));
    if (!system.is_string()) return std::nullopt;
    return GeoReference{GeoReference::Frame::geocentric, 0, 0, 0, system.get<std::string>()};
  }
  const auto latitude = number_in(value, "latitude", 90), longitude = number_in(value, "longitude", 180),
             altitude = number_in(value, "altitude", kMostAltitude);
  if (value["frame"] != kEastNorthUp || !latitude || !longitude || !altitude) return std::nullopt;
  return GeoReference{GeoReference::Frame::east_north_up, *latitude, *longitude, *altitude, {}};
}

std::string text_of(const GeoReference& reference) {
  if (reference.frame == GeoReference::Frame::geocentric) {
    const std::string metres = "metres from the Earth's centre (geocentric), of ";
    return metres + (reference.system.empty() ? "WGS 84" : "the reference system " + short_reason(reference.system));
  }
  return "metres east, north and up of latitude " + number_text(reference.latitude_deg) + ", longitude " +
         number_text(reference.longitude_deg) + " and altitude " + number_text(reference.altitude_m) + " (WGS 84)";
}

std::optional<std::string> unplaced_warning(const std::optional<GeoReference>& reference) {
  if (!reference || geocentric_from_scene(*reference)) return std::nullopt;
  return "other programs show the model in its own coordinates, and not where it lies on the Earth: these are " +
         text_of(*reference) + ", whose ellipsoid is not that of WGS 84";
}

}  // namespace lumatlas
