// SPDX-License-Identifier: GPL-3.0-or-later
// Diagnosis of models: how far apart their photographs show the same points of the surface, and whether poses or the
// surface are to blame. A table in Markdown or JSON goes to stdout; exit status as of lumatlas itself.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/model/model_file.h"
#include "tools/base/output_folder.h"
#include "tools/lab/bench/program.h"
#include "tools/lab/diagnosis/flow_summary.h"
#include "tools/lab/diagnosis/view_flow.h"
#include "tools/score/report/json_fields.h"

namespace lumatlas {

namespace {

using nlohmann::json;

struct Flags {
  std::vector<std::filesystem::path> models;
  bool by_view = false;
  bool json_output = false;
};

json json_flow(const FlowSummary& summary) {
  return {{"patches", summary.patches},
          {"counting_share", summary.counting_share},
          {"length_px", json_number(summary.length)},
          {"length_p90_px", json_number(summary.length_p90)},
          {"along_px", json_number(summary.along)},
          {"across_px", json_number(summary.across)},
          {"along_share", json_number(summary.along_share)},
          {"local_px", json_number(summary.local)}};
}

void print_row(const std::string& name, const FlowSummary& summary) {
  std::cout << "| " << name << " | " << summary.patches << " | " << std::fixed << std::setprecision(0)
            << 100 * summary.counting_share << " % | " << std::setprecision(2) << summary.length << " | "
            << summary.length_p90 << " | " << summary.along << " | " << summary.across << " | " << std::setprecision(0)
            << 100 * summary.along_share << " % | " << std::setprecision(2) << summary.local << " |\n"
            << std::flush;
}

void run(const Flags& flags) {
  json models = json::object();
  if (!flags.json_output) {
    std::cout << "| model | patches | that count | flow, px | 90 % | along | across | along, of the squares | local |\n"
                 "|---|---|---|---|---|---|---|---|---|\n";
  }
  for (const std::filesystem::path& path : flags.models) {
    const Model model = read_model(path);
    const ViewFlow flow = view_flow(model.snapshot);
    const FlowSummary whole = flow_summary(flow);
    json& entry = models[path.string()] = json_flow(whole);
    if (!flags.json_output) print_row(std::filesystem::weakly_canonical(path).filename().string(), whole);
    if (!flags.by_view) continue;
    const std::vector<FlowSummary> views = flow_summaries_by_view(flow);
    for (std::size_t slot = 0; slot < views.size(); ++slot) {
      if (!model.snapshot.views[slot]) continue;
      const std::string& name = model.snapshot.views[slot]->name;
      entry["views"][name] = json_flow(views[slot]);
      if (!flags.json_output) print_row(name, views[slot]);
    }
  }
  if (flags.json_output) std::cout << json_text({{"models", models}});
}

}  // namespace

}  // namespace lumatlas

int main(int argc, char** argv) {
  using namespace lumatlas;
  CLI::App program("How far apart the photographs of a model show the same points of its surface, and why");
  Flags flags;
  program.add_option("MODEL", flags.models, "Folders or .glb that `lumatlas build` wrote")->required();
  program.add_flag("--by-view", flags.by_view, "Also a line for each photograph");
  program.add_flag("--json", flags.json_output, "Print JSON");
  return run_program(program, "bench_flow", argc, argv, [&flags] { run(flags); });
}
