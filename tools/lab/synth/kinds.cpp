// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/synth/kinds.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

constexpr std::array kKinds{
    SynthKindRow{SynthKind::apartment, "apartment", "two furnished rooms with glossy floors", SynthTrajectory::walk,
                 synth::make_apartment},
    SynthKindRow{SynthKind::village, "village", "streets of houses under the sky, 60 units across",
                 SynthTrajectory::hilbert, synth::make_village},
    SynthKindRow{SynthKind::wall, "wall", "a house front in fine relief", SynthTrajectory::walk, synth::make_wall},
    SynthKindRow{SynthKind::lab, "lab", "a cluttered room whose mesh is a noisy, incomplete scan",
                 SynthTrajectory::walk, synth::make_lab},
};

constexpr std::array kTrajectories{
    SynthTrajectoryRow{SynthTrajectory::walk, "walk"},
    SynthTrajectoryRow{SynthTrajectory::hilbert, "hilbert"},
    SynthTrajectoryRow{SynthTrajectory::orbit, "orbit"},
    SynthTrajectoryRow{SynthTrajectory::random, "random"},
};

template <typename Rows>
const auto& row_named(const Rows& rows, std::string_view name, const char* field) {
  std::string names;
  for (const auto& row : rows) {
    if (name == row.name) return row;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("synth: " + std::string(field) + " is " + std::string(name) + ", must be one of " +
                              names);
}

template <typename Rows, typename Wanted>
const auto& row_with(const Rows& rows, const Wanted& wanted, const char* field) {
  const auto row = std::find_if(rows.begin(), rows.end(), wanted);
  if (row == rows.end()) throw std::invalid_argument("synth: " + std::string(field) + " is not an enumerator");
  return *row;
}

}  // namespace

std::span<const SynthKindRow> synth_kinds() {
  return kKinds;
}

const SynthKindRow& synth_kind(SynthKind kind) {
  return row_with(
      kKinds, [&](const SynthKindRow& row) { return row.kind == kind; }, "kind");
}

SynthKind synth_kind_named(std::string_view name) {
  return row_named(kKinds, name, "kind").kind;
}

std::span<const SynthTrajectoryRow> synth_trajectories() {
  return kTrajectories;
}

const SynthTrajectoryRow& synth_trajectory(const SynthOptions& options) {
  const SynthTrajectory wanted = options.trajectory.value_or(synth_kind(options.kind).trajectory);
  return row_with(
      kTrajectories, [&](const SynthTrajectoryRow& row) { return row.trajectory == wanted; }, "trajectory");
}

SynthTrajectory synth_trajectory_named(std::string_view name) {
  return row_named(kTrajectories, name, "trajectory").trajectory;
}

namespace synth {

Scene make_scene(const SynthOptions& options) {
  check(options);
  const auto [columns, rows] = options.district;
  if (columns > 1 || rows > 1) return make_district(options.seed, options.triangles, columns, rows);
  return synth_kind(options.kind).make(options.seed, options.triangles);
}

}  // namespace synth

}  // namespace lumatlas
