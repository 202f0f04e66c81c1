// SPDX-License-Identifier: GPL-3.0-or-later
// Georeferences as people and files tell them.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "atlas/earth_frame.h"

namespace lumatlas {

// The file beside a scene that says where its coordinates lie, as OpenSfM and OpenDroneMap write it: an object with
// "latitude", "longitude" and "altitude" of the origin, to which x is east, y north and z up, metres.
inline constexpr const char* kReferenceFile = "reference_lla.json";

// Reads kReferenceFile in the scene's folder, or in opensfm/ in it. Without such a file there is none, nor where it
// says 0 degrees, as OpenSfM does without GPS. Throws InputError for a file of other content.
[[nodiscard]] std::optional<GeoReference> reference_beside(const std::filesystem::path& scene);

// Returns the file that reference_beside() reads; none if there is none.
[[nodiscard]] std::optional<std::filesystem::path> reference_file_beside(const std::filesystem::path& scene);

// Returns the reference for "48.2,-16.4,190": latitude and longitude of the origin in degrees, and its altitude, to
// which x is east, y north and z up; or for "geocentric". Spaces and parentheses around the numbers do not matter.
// Throws std::invalid_argument, a sentence that begins with the text.
[[nodiscard]] GeoReference parse_geo_reference(std::string_view text);

// Returns an object: "frame", and "latitude", "longitude", "altitude" or "system".
[[nodiscard]] nlohmann::json json_of(const GeoReference& reference);

// Returns what json_of() made; nothing for any other value.
[[nodiscard]] std::optional<GeoReference> geo_reference_of(const nlohmann::json& value);

// Returns a part of a sentence about coordinates, in one line: "metres east, north and up of latitude 48 ...".
[[nodiscard]] std::string text_of(const GeoReference& reference);

// Returns the warning that a tileset cannot say where coordinates lie, whose ellipsoid is not that of WGS 84; nothing
// where it can, and without a reference.
[[nodiscard]] std::optional<std::string> unplaced_warning(const std::optional<GeoReference>& reference);

}  // namespace lumatlas
