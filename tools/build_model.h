// SPDX-License-Identifier: GPL-3.0-or-later
// The main job: a scene's photographs, offered to the planner one by one in order of their names, become a model.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/cells.h"
#include "planner/planner.h"
#include "tools/scene.h"

namespace lumatlas {

// What is made to agree before a view is stored: see planner/refiner.h.
enum class RefineMode {
  none,
  exposure,  // gains
  pose,      // poses, gains stay 1
  all,       // gains, poses, and masks of what the other views contradict
  joint,     // and afterwards all stored views together, until they rest
};

// What to do about the intrinsics that the stored views ask for, after polishing.
enum class IntrinsicsUse { ignore, report, apply };

// What finds the visible surface; the two agree but at silhouettes.
enum class VisibilityBy {
  rays,  // mesh/visibility.h, on the processor
  gl,    // blend/gl_visibility.h, on the GPU that EGL finds, else on Mesa's software driver
};

struct BuildOptions {
  std::optional<std::filesystem::path> mesh;  // none: looked for beside the scene
  CellOptions cells;
  VisibilityBy visibility_by = VisibilityBy::rays;
  PlannerOptions planner;                 // coverage.ideal_distance 0: the median camera-surface distance of the scene
  RefineMode refine = RefineMode::joint;  // switches off what planner.refinement has on, never on
  std::uint32_t max_polish_steps = 15;    // of RefineMode::joint, >= 1
  IntrinsicsUse intrinsics = IntrinsicsUse::ignore;
  std::uint32_t max_views = 100;    // N, >= 1
  std::optional<HoldOut> hold_out;  // none: every view is offered
  bool quiet = false;
};

// What became of one view that was offered.
struct PlannedView {
  std::string name;
  Verdict verdict;
};

struct BuildResult {
  Snapshot snapshot;
  std::vector<PlannedView> planned;  // in the order of the stream
  std::filesystem::path mesh_file;
  PlannerOptions effective;                      // with every automatic value filled in
  std::optional<IntrinsicsEstimate> intrinsics;  // none: ignored
  bool intrinsics_applied = false;
  double summed_coverage = 0;
  std::vector<PolishStep> polish;  // of RefineMode::joint
  double polish_ms = 0;
  double total_ms = 0;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const BuildOptions& options);

// Checks the options before it reads anything. Throws InputError, what check() throws, and with VisibilityBy::gl
// GlError.
[[nodiscard]] BuildResult build_model(const std::filesystem::path& scene, const BuildOptions& options);

// What `build --json` prints (DESIGN: machine-readable results).
[[nodiscard]] nlohmann::json summary(const BuildResult& result, const BuildOptions& options);

// One sentence, if the estimate is significant; else empty.
[[nodiscard]] std::string intrinsics_advice(const IntrinsicsEstimate& estimate, bool applied);

// The options as they were used, for the file beside the output.
[[nodiscard]] nlohmann::json effective_options(const BuildResult& result, const BuildOptions& options);

// One entry per offered view: its decision, gain and times.
[[nodiscard]] nlohmann::json plan_json(const BuildResult& result);

}  // namespace lumatlas
