// SPDX-License-Identifier: GPL-3.0-or-later
// Benchmark of refinement: what it leaves of known errors, and what it costs. Results go to stdout, as tables in
// Markdown or as JSON; exit status as of lumatlas itself.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tools/base/output_folder.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/bench/refinement_accuracy.h"
#include "tools/lab/bench/refinement_time.h"
#include "tools/score/report/json_fields.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct RefinementFlags {
  std::string refine = "all";
  bool white_balance = false;
  double prior = AlignmentOptions{}.prior;
  std::uint32_t revisits = RefinementOptions{}.revisits;

  void add_to(CLI::App& command) {
    command.add_option("--refine", refine, "none, exposure, pose, all or joint")
        ->check(CLI::IsMember({"none", "exposure", "pose", "all", "joint"}));
    command.add_flag("--white-balance", white_balance, "An exposure gain for each colour channel");
    command.add_option("--revisits", revisits, "Stored views that are refined again after each one that is stored");
    command.add_option("--prior", prior, "Strength of the pull towards the given pose")->check(finite_not_negative());
  }
  [[nodiscard]] bool joint() const { return refine == "joint"; }
  void apply(RefinementOptions& refinement) const {
    AlignmentOptions& options = refinement.alignment;
    refinement.revisits = revisits;
    options.pose = refine == "pose" || refine == "all" || joint();
    options.exposure = refine == "exposure" || refine == "all" || joint();
    options.white_balance = white_balance;
    options.prior = prior;
  }
};

struct ExactFlags {
  std::vector<std::filesystem::path> scenes;
  RefinementFlags refinement;
  bool json_output = false;
};

struct TimeFlags {
  std::vector<std::filesystem::path> scenes;
  std::filesystem::path mesh;
  RefinementFlags refinement;
  std::vector<double> megapixels;
  bool json_output = false;
};

std::string short_name(const std::filesystem::path& scene) {
  return std::filesystem::weakly_canonical(scene).filename().string();
}

void run_exact(const ExactFlags& flags) {
  BuildOptions options = options_to_keep_all();
  options.refine = flags.refinement.joint() ? RefineMode::joint : RefineMode::all;
  flags.refinement.apply(options.planner.refinement);
  json scenes = json::object();
  if (!flags.json_output) std::cout << accuracy_table_head();
  for (const std::filesystem::path& scene : flags.scenes) {
    const json accuracy = json_accuracy(measure_refinement(scene, options));
    if (!flags.json_output) std::cout << accuracy_table_row(short_name(scene), accuracy) << std::flush;
    scenes[scene.string()] = accuracy;
  }
  if (flags.json_output) std::cout << json_text({{"scenes", scenes}});
}

// Returns the time of Erat et al. 2019, Table 2, for two sizes; a tenth of it is the goal.
std::optional<double> paper_ms(double megapixels) {
  struct Known {
    double megapixels, ms;
  };
  for (const Known& known : {Known{0.3, 60}, Known{3.0, 350}}) {
    if (std::abs(megapixels / known.megapixels - 1) < 0.15) return known.ms;
  }
  return std::nullopt;
}

std::string times_row(const std::string& scene, const RefinementTimes& times) {
  const std::optional<double> paper = paper_ms(times.megapixels);
  std::ostringstream row;
  row << std::fixed << std::setprecision(2) << "| " << scene << " | " << times.megapixels << " | " << times.refined
      << std::setprecision(0) << " | " << times.median_ms << " | " << times.p95_ms << " | ";
  if (paper) {
    row << *paper << " | " << *paper / 10 << " |\n";
  } else {
    row << "- | - |\n";
  }
  return row.str();
}

json json_times(const std::filesystem::path& scene, const RefinementTimes& times) {
  const std::optional<double> paper = paper_ms(times.megapixels);
  return {{"scene", scene.string()},
          {"megapixels", times.megapixels},
          {"refined", times.refined},
          {"median_ms", json_number(times.median_ms)},
          {"p95_ms", json_number(times.p95_ms)},
          {"paper_ms", paper ? json(*paper) : json(nullptr)}};
}

void run_time(const TimeFlags& flags) {
  PlannerOptions options = options_to_keep_all().planner;
  flags.refinement.apply(options.refinement);
  std::optional<std::filesystem::path> mesh;
  if (!flags.mesh.empty()) mesh = flags.mesh;
  std::vector<std::optional<double>> sizes(flags.megapixels.begin(), flags.megapixels.end());
  if (sizes.empty()) sizes.emplace_back();
  json runs = json::array();
  if (!flags.json_output) {
    std::cout << "| scene | Mpixel | views refined | median, ms | 95th percentile, ms | paper, ms | goal, ms |\n"
                 "|---|---|---|---|---|---|---|\n";
  }
  for (const std::filesystem::path& scene : flags.scenes) {
    for (const std::optional<double>& size : sizes) {
      const RefinementTimes times = time_refinement(scene, mesh, options, size);
      if (!flags.json_output) std::cout << times_row(short_name(scene), times) << std::flush;
      runs.push_back(json_times(scene, times));
    }
  }
  if (flags.json_output) std::cout << json_text({{"runs", runs}});
}

void add_exact_command(CLI::App& program, ExactFlags& flags) {
  CLI::App* command = program.add_subcommand("exact", "What refinement leaves of the known errors of synthetic scenes");
  command->add_option("SCENE", flags.scenes, "Folders of `lumatlas synth` with known errors")->required();
  flags.refinement.add_to(*command);
  command->add_flag("--json", flags.json_output, "Print JSON, with an entry for each view");
  command->callback([&flags] { run_exact(flags); });
}

void add_time_command(CLI::App& program, TimeFlags& flags) {
  CLI::App* command = program.add_subcommand("time", "What refining a view costs, 60 evenly spaced views at most");
  command->add_option("SCENE", flags.scenes, "COLMAP workspaces with a mesh")->required();
  command->add_option("--mesh", flags.mesh,
                      "PLY, OBJ, STL or GLB; without it the usual names are looked for in each SCENE");
  flags.refinement.add_to(*command);
  command
      ->add_option("--megapixels", flags.megapixels,
                   "Scale photographs to about this size, once for each; none: their own size")
      ->allow_extra_args(false)
      ->check(number_between(0.001, 1000));
  command->add_flag("--json", flags.json_output, "Print JSON");
  command->callback([&flags] { run_time(flags); });
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  CLI::App program("Benchmark of lumatlas's refinement of exposure and pose");
  program.option_defaults()->always_capture_default();
  program.require_subcommand(1);
  lumatlas::ExactFlags exact;
  lumatlas::TimeFlags time;
  lumatlas::add_exact_command(program, exact);
  lumatlas::add_time_command(program, time);
  return lumatlas::run_program(program, "bench_refine", argc, argv);
}
