// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "atlas/model_file.h"
#include "tools/build_model.h"
#include "tools/cell_flags.h"
#include "tools/commands.h"
#include "tools/number_flags.h"
#include "tools/output_folder.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct BuildFlags {
  std::filesystem::path scene, output, mesh;
  BuildOptions options;
  HoldFlags hold;
  CellFlags cells;
  std::string refine = "all";
  std::string metric = "departures";
  bool refine_intrinsics = false;
  bool json_output = false;
};

void print_summary(const json& s, const std::filesystem::path& output) {
  const json& views = s["views"];
  std::cout << output.string() << ": " << s["cells"] << " cells (" << s["cells_seen"] << " seen, "
            << s["cells_referenced"] << " textured); of " << views["offered"] << " views " << views["kept"] << " kept, "
            << views["replaced"] << " took another's place, " << views["rejected"] << " rejected; " << s["references"]
            << " references, " << s["texels"]["resident"] << " texels; "
            << std::to_string(static_cast<long>(s["time_ms"]["total"].get<double>() / 1000)) << " s\n";
}

void run(const BuildFlags& flags) {
  BuildOptions options = flags.options;
  if (!flags.mesh.empty()) options.mesh = flags.mesh;
  options.hold_out = flags.hold.protocol();
  options.cells = flags.cells.options();
  if (flags.metric == "printed") options.planner.coverage.metric = CoverageOptions::Metric::printed;
  AlignmentOptions& alignment = options.planner.refinement.alignment;
  alignment.pose = flags.refine != "none" && flags.refine != "exposure";
  alignment.exposure = flags.refine != "none" && flags.refine != "pose";
  if (flags.refine == "joint") {
    options.intrinsics = flags.refine_intrinsics ? IntrinsicsUse::apply : IntrinsicsUse::report;
  } else if (flags.refine_intrinsics) {
    throw CLI::ValidationError("--refine-intrinsics", "needs --refine joint");
  }
  check_usage(options);
  OutputFolder output(flags.output);
  const BuildResult result = build_model(flags.scene, options);
  if (!options.quiet && flags.mesh.empty()) std::cerr << "mesh: " << result.mesh_file.string() << '\n';
  write_model(output.path(), result.snapshot, options.planner.validity);
  if (result.intrinsics) {
    const std::string advice = intrinsics_advice(*result.intrinsics, result.intrinsics_applied);
    if (!advice.empty()) std::cerr << advice << '\n';
  }
  const json totals = summary(result, options);
  json plan = plan_json(result);
  plan["summary"] = totals;
  write_json(output.path() / "plan.json", plan);
  output.commit(effective_options(result, options));
  if (flags.json_output) {
    std::cout << json_text(totals);
  } else {
    print_summary(totals, flags.output);
  }
}

void add_planner_options(CLI::App& command, BuildFlags& flags) {
  PlannerOptions& planner = flags.options.planner;
  command.add_option("--views", flags.options.max_views, "Photographs that the model may hold")
      ->check(CLI::Range(1u, 1u << 20));
  command.add_option("--references", planner.coverage.max_references, "Views that a cell may refer to")
      ->check(CLI::Range(1u, 1u << 16));
  command
      .add_option("--coverage-lambda", planner.coverage.lambda,
                  "Weight of direction against position when views are chosen")
      ->check(number_between(0, 1));
  command
      .add_option("--ideal-distance", planner.coverage.ideal_distance,
                  "Camera distance at which a cell is covered best, scene units; 0: the scene's median")
      ->check(finite_not_negative());
  command
      .add_option("--distance-sigma", planner.coverage.distance_sigma,
                  "How far from it coverage falls to 0.6, scene units; 0: half of it")
      ->check(finite_not_negative());
  command
      .add_option("--max-cell-coverage", planner.coverage.max_cell_coverage,
                  "Coverage above which a cell counts no further views; 0: half of --references")
      ->check(finite_not_negative());
  command
      .add_option("--min-gain", planner.min_view_gain,
                  "Coverage that a view must add, as a share of the cells that it sees")
      ->check(finite_not_negative());
  command
      .add_option("--visibility", planner.visibility_px, "Longer side, pixels, of the image that cells are counted in")
      ->check(CLI::Range(1u, 65536u));
  command
      .add_option("--fade", planner.validity.fade_px,
                  "Pixels over which a photograph fades at its border and at depth edges")
      ->check(CLI::Range(0u, 255u));
  command.add_option("--refine", flags.refine, "none, exposure, pose, all or joint")
      ->check(CLI::IsMember({"none", "exposure", "pose", "all", "joint"}));
  command.add_flag("--refine-intrinsics", flags.refine_intrinsics,
                   "With --refine joint: correct focal length and principal point where the photographs ask for it");
  command.add_flag("--white-balance", planner.refinement.alignment.white_balance, "");
  command.add_option("--prior", planner.refinement.alignment.prior, "");
  command.add_flag("!--no-trust", planner.refinement.trust.enabled, "");
  command.add_option("--trust-deg", planner.refinement.trust.comparable_deg, "");
  command.add_option("--trust-diff", planner.refinement.trust.least_difference, "");
  command.add_option("--trust-spread", planner.refinement.trust.least_to_spread, "");
  command.add_flag("!--no-clip", planner.refinement.trust.overexposed, "");
  command.add_option("--least-correlation", planner.refinement.least_correlation, "");
  command.add_option("--least-improvement", planner.refinement.alignment.least_improvement, "");
  command.add_option("--samples", planner.refinement.samples, "");
  command.add_option("--polish-steps", flags.options.polish_steps, "");
  command.add_option("--metric", flags.metric, "Coverage metric: departures (from the paper's print) or printed")
      ->check(CLI::IsMember({"departures", "printed"}));
}

}  // namespace

void add_build_command(CLI::App& program) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* command = program.add_subcommand("build", "Plan, cross-reference and save a model: the main job");
  command->add_option("SCENE", flags->scene, "COLMAP workspace: sparse/ and images/, with a mesh")->required();
  command->add_option("-o,--output", flags->output, "Folder of the model; an earlier model there is replaced")
      ->required();
  command->add_option("--mesh", flags->mesh, "PLY or OBJ; without it the usual names are looked for in SCENE");
  flags->cells.add_to(*command);
  add_planner_options(*command, *flags);
  flags->hold.add_to(*command, "Leave out every H-th view by name, to be scored by `validate`");
  command->add_flag("--json", flags->json_output, "Print what was built as JSON");
  command->add_flag("--quiet", flags->options.quiet, "No progress");
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
