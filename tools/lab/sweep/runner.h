// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the points of sweeps, each by the program itself as a child: synth, build, validate; before build also mesh,
// for points with options of it. What was made is kept and not made again:
//
//   DIR/scenes/KIND-KEY/  a synthetic scene, made once for all points and sweeps that need it
//   DIR/points/KEY/       build.json and scores.json of a point, and lumatlas.json: its options, commands and program
//
// Both appear complete or not at all. Models and meshes are removed once they are scored.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lab/sweep/points.h"

namespace lumatlas {

struct SweepRunOptions {
  std::filesystem::path program;  // lumatlas
  std::string identity;           // of the program: points that another one made are made again
  std::filesystem::path output;   // DIR, made if it is missing
  std::filesystem::path scenes;   // that folders of scenes are in; empty: none
  std::size_t jobs = 1;           // points made side by side, >= 1
  bool keep_points = false;       // use points that another program made
  std::vector<std::string> only;  // shell patterns of points' names, of which one must match; none: all points
  bool quiet = false;
};

struct PointResult {
  enum class Status { done, failed, skipped, left_out };  // skipped: its scene is not there; left_out: by `only`

  SweepPoint point;
  Status status = Status::left_out;
  std::string reason;                 // of `failed` and `skipped`, one sentence
  std::string made_by;                // the program's identity
  bool made_now = false;              // not found
  std::vector<std::string> commands;  // that made it, with SCENE, MESH and MODEL for the paths
  nlohmann::json build, scores;       // null unless it is done
};

[[nodiscard]] const char* name_of(PointResult::Status status);

class SweepRunner {
 public:
  // Throws InputError where DIR cannot be made, or another runner is at work in it.
  explicit SweepRunner(SweepRunOptions options);
  ~SweepRunner();
  SweepRunner(const SweepRunner&) = delete;
  SweepRunner& operator=(const SweepRunner&) = delete;

  // The points as points_of() has them. A point that fails says so, and the rest goes on. Throws Interrupted if the
  // user has asked the program to stop.
  [[nodiscard]] std::vector<PointResult> run(const Sweep& sweep);

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace lumatlas
