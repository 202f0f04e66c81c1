// SPDX-License-Identifier: GPL-3.0-or-later
// The place of a scene's coordinates on the Earth.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace lumatlas {

// The georeference that a form of capture gives for its cameras. The mesh is assumed to share it.
struct GeoReference {
  enum class Frame {
    east_north_up,  // metres east, north and up of the origin below
    geocentric,     // metres from the Earth's centre, z to the north pole (EPSG:4978 for WGS 84)
  };
  Frame frame = Frame::east_north_up;
  double latitude_deg = 0;   // the origin's, WGS 84, [-90, 90]
  double longitude_deg = 0;  // [-180, 180]
  double altitude_m = 0;     // above the ellipsoid, as far as the form says so
  std::string system = {};   // for Frame::geocentric: the coordinate reference system, as the form names it (WKT)

  friend bool operator==(const GeoReference&, const GeoReference&) = default;
};

// Returns an object: "frame", and "latitude", "longitude", "altitude" or "system".
[[nodiscard]] nlohmann::json json_of(const GeoReference& reference);

// Returns what json_of() made; nothing for any other value.
[[nodiscard]] std::optional<GeoReference> geo_reference_of(const nlohmann::json& value);

// Returns a part of a sentence about coordinates, in one line: "metres east, north and up of latitude 48 ...".
[[nodiscard]] std::string text_of(const GeoReference& reference);

}  // namespace lumatlas
