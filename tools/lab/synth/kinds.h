// SPDX-License-Identifier: GPL-3.0-or-later
// The kinds of synthetic scenes and their trajectories: a new kind is a row of the table, and a file with the function
// that makes it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "tools/lab/synth/synth.h"

namespace lumatlas {

struct SynthKindRow {
  SynthKind kind;
  const char* name;            // on the command line
  const char* description;     // in the help: what is in it
  SynthTrajectory trajectory;  // unless the options name another
  // Makes the scene in about `triangles` triangles. Everything else depends on the seed alone.
  synth::Scene (*make)(std::uint64_t seed, std::uint32_t triangles);
};

// One row per kind, in the order of the help.
[[nodiscard]] std::span<const SynthKindRow> synth_kinds();
[[nodiscard]] const SynthKindRow& synth_kind(SynthKind kind);
// Throws std::invalid_argument naming the kinds that there are.
[[nodiscard]] SynthKind synth_kind_named(std::string_view name);

struct SynthTrajectoryRow {
  SynthTrajectory trajectory;
  const char* name;
};
[[nodiscard]] std::span<const SynthTrajectoryRow> synth_trajectories();
// The one that the options name, else the kind's.
[[nodiscard]] const SynthTrajectoryRow& synth_trajectory(const SynthOptions& options);
// Throws std::invalid_argument naming the trajectories that there are.
[[nodiscard]] SynthTrajectory synth_trajectory_named(std::string_view name);

}  // namespace lumatlas
