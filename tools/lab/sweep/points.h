// SPDX-License-Identifier: GPL-3.0-or-later
// The points of a sweep: which scene is made, built and scored with which options.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/lab/sweep/sweep.h"

namespace lumatlas {

struct SweepPoint {
  std::size_t scene = 0, series = 0, value = 0;  // of the sweep; value: of the series
  std::optional<std::uint64_t> seed;             // of the stream's order; none: the given order
  std::string name;                              // "apartment/directions/16/2": scene, series, value and seed
  std::string kind, folder;                      // of the scene, one of them empty
  OptionValues synth, mesh, build, validate;     // all that are given; mesh: none if the scene's own is used
  // The options of the scene whose photographs are scored: those of synth without what series and value add.
  OptionValues scored_synth;
};

// Returns the points of every scene, series, value and seed. Points that are to be compared follow each other, so that
// a machine that is busy for a while disturbs all of them: seeds are outermost, then scenes, values, and series
// innermost.
[[nodiscard]] std::vector<SweepPoint> points_of(const Sweep& sweep);

// All that the result depends on, apart from the program: the same for points that need to be made only once.
[[nodiscard]] nlohmann::json description_of(const SweepPoint& point);

// Returns the key of a description or of options: 16 hexadecimal digits, the same on every machine.
[[nodiscard]] std::string key_of(const nlohmann::json& description);

// The description of a synthetic scene.
[[nodiscard]] nlohmann::json scene_description(const std::string& kind, const OptionValues& synth);

}  // namespace lumatlas
