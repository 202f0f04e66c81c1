// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how long planning a view takes, as the planner reports it. Photographs are blank and nothing is refined, so
// only the surface, the cameras and the planner's options matter.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/visibility/visibility.h"
#include "planner/planner.h"

namespace lumatlas {

// A surface, and the cameras of a stream of views of it.
struct PlanningScene {
  std::string name;
  std::shared_ptr<const Surface> surface;
  std::vector<Camera> cameras;
};

// A folder's mesh and evenly spaced ones of its views, `most_views` at most. Throws InputError.
[[nodiscard]] PlanningScene load_planning_scene(const std::filesystem::path& folder, std::size_t most_views);

// A walk through the furnished apartment of `lumatlas synth`, its surfaces made uneven as those of scanned rooms are.
struct ApartmentOptions {
  std::uint32_t triangles = 1'600'000;  // the mesh's, within 1 %
  std::uint32_t views_per_lap = 500;    // >= 1
  std::uint32_t laps = 1;               // >= 1; views at the same place in their laps are close, but none is the same
  std::uint32_t width = 640;            // the photographs', pixels
  std::uint32_t height = 480;
};

// Says on stderr what it is doing, because large meshes take a minute. Throws std::invalid_argument if the walk is not
// one that SynthOptions allow, std::runtime_error if the furniture needs more triangles.
[[nodiscard]] PlanningScene make_planning_scene(const ApartmentOptions& options);

// The times of one view of the stream: milliseconds of wall time, unless stated.
struct PlannedTime {
  double visibility_ms = 0;
  double decision_ms = 0;
  double cpu_ms = 0;  // the whole of it, storing included, in all threads of this process: other work does not count
  Decision decision = Decision::rejected;
  std::uint64_t resident_bytes = 0;  // this process's, afterwards

  [[nodiscard]] double planning_ms() const { return visibility_ms + decision_ms; }
};

// Offers all views in their order to a store of `max_views`. coverage.ideal_distance is taken from the scene, and
// nothing is refined, whatever the options say.
[[nodiscard]] std::vector<PlannedTime> time_planning(const PlanningScene& scene, const Visibility& visibility,
                                                     PlannerOptions options, std::uint32_t max_views);

struct Spread {
  double median = 0, p95 = 0;  // NaN for no views
};
[[nodiscard]] Spread spread(std::span<const PlannedTime> times, double (*value)(const PlannedTime&));

}  // namespace lumatlas
