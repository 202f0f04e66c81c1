// SPDX-License-Identifier: GPL-3.0-or-later
// The option that says where a scene lies on the Earth.
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>

#include "tools/cli/flags/option_rules.h"
#include "tools/scene/geo_reference.h"

namespace lumatlas {

struct GeoreferenceFlag {
  std::string text;  // empty: not given

  void add_to(CLI::App& command) {
    command
        .add_option(
            "--georeference", text,
            "Latitude and longitude of the poses' origin in degrees and its altitude, such as 48.2,-16.4,190; x is "
            "east, y north, z up, metres. Or geocentric")
        ->type_name("LAT,LON,ALT")
        ->check(parsed_by(parse_geo_reference))
        ->default_str("as the scene says");
  }
  [[nodiscard]] std::optional<GeoReference> reference() const {
    if (text.empty()) return std::nullopt;
    return parse_geo_reference(text);
  }
};

}  // namespace lumatlas
