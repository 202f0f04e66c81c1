// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/sweep/points.h"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace lumatlas {

namespace {

using nlohmann::json;

SweepPoint point_of(const Sweep& sweep, std::size_t scene, std::size_t series, std::size_t value,
                    std::optional<std::uint64_t> seed) {
  const SweepScene& of_scene = sweep.scenes[scene];
  const SweepSeries& of_series = sweep.series[series];
  const SweepValue& of_value = of_series.values[value];
  CommandOptions options = sweep.options;
  overlay(options, of_scene.options);
  const OptionValues undisturbed = options.synth;
  overlay(options, of_series.options);
  overlay(options, of_value.options);
  SweepPoint point{scene,
                   series,
                   value,
                   seed,
                   of_scene.name + "/" + of_series.label + "/" + of_value.label,
                   of_scene.kind,
                   of_scene.folder,
                   options.synth,
                   options.mesh,
                   options.build,
                   options.validate,
                   sweep.scored_undisturbed ? undisturbed : options.synth};
  if (seed) {
    point.name += "/" + std::to_string(*seed);
    point.build["stream.order"] = {.given = true, .text = "shuffled"};
    point.build["stream.seed"] = {.given = true, .text = std::to_string(*seed)};
  }
  return point;
}

// No seed for a series that is not repeated, and it is there once.
std::vector<std::optional<std::uint64_t>> seeds_of(const Sweep& sweep) {
  std::vector<std::optional<std::uint64_t>> seeds{std::nullopt};
  for (std::uint64_t seed = 1; seed <= sweep.repeats; ++seed) seeds.emplace_back(seed);
  return seeds;
}

// FNV-1a, 64 bits: short, and a matter of course on every machine.
std::uint64_t hash_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325;
  for (const unsigned char c : text) hash = (hash ^ c) * 0x100000001b3;
  return hash;
}

}  // namespace

std::vector<SweepPoint> points_of(const Sweep& sweep) {
  std::size_t most_values = 0;
  for (const SweepSeries& series : sweep.series) most_values = std::max(most_values, series.values.size());
  std::vector<SweepPoint> points;
  for (const auto& seed : seeds_of(sweep)) {
    for (std::size_t scene = 0; scene < sweep.scenes.size(); ++scene) {
      for (std::size_t value = 0; value < most_values; ++value) {
        for (std::size_t series = 0; series < sweep.series.size(); ++series) {
          const bool is_repeated = sweep.repeats > 0 && !sweep.series[series].once;
          if (value >= sweep.series[series].values.size() || is_repeated != seed.has_value()) continue;
          points.push_back(point_of(sweep, scene, series, value, seed));
        }
      }
    }
  }
  return points;
}

json scene_description(const std::string& kind, const OptionValues& synth) {
  return {{"kind", kind}, {"synth", arguments_of(synth)}};
}

json description_of(const SweepPoint& point) {
  json description = {{"build", arguments_of(point.build)}, {"validate", arguments_of(point.validate)}};
  if (!point.mesh.empty()) description["mesh"] = arguments_of(point.mesh);
  if (!point.folder.empty()) {
    description["folder"] = point.folder;
  } else {
    description["scene"] = scene_description(point.kind, point.synth);
    description["scored"] = scene_description(point.kind, point.scored_synth);
  }
  return description;
}

std::string key_of(const json& description) {
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash_of(description.dump())));
  return text;
}

}  // namespace lumatlas
