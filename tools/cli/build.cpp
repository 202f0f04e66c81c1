// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "tools/base/output_folder.h"
#include "tools/cli/build_watch.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/build_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/cli/output/next_steps.h"
#include "tools/cli/shown_build.h"
#include "tools/pipeline/output/build_summary.h"
#include "tools/pipeline/output/model_inspection.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/refinement/refinement_json.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas {

namespace {

// Returns a line that counts the photographs that were left out, and one for each.
std::string skipped_text(const BuildResult& result) {
  if (result.skipped.empty()) return "";
  std::string lines = "warning: " + std::to_string(result.skipped.size()) + " of " + std::to_string(result.views) +
                      " photographs are left out\n";
  for (const SkippedView& view : result.skipped) lines += "  " + view.why + '\n';
  return lines;
}

std::string scene_text(const BuildFlags& flags, const BuildResult& result) {
  std::string lines;
  if (flags.mesh.empty()) lines += "mesh: " + result.mesh_file.string() + '\n';
  for (const std::string& note : result.scene_notes) lines += "scene: " + note + '\n';
  if (result.masked_views > 0) {
    lines +=
        "masks: of " + std::to_string(result.masked_views) + " of " + std::to_string(result.views) + " photographs\n";
  }
  if (flags.options.close_holes > 0) {
    lines += "mesh: closed " + std::to_string(result.closed_holes) + " of its holes\n";
  }
  return lines;
}

void tell(const BuildFlags& flags, const BuildResult& result) {
  if (!flags.quiet) std::cerr << scene_text(flags, result);
  if (!flags.watch) std::cerr << skipped_text(result);  // with it, each was named as it was found
  for (const std::string& warning : result.warnings) std::cerr << "warning: " << warning << '\n';
  if (flags.verbose) std::cerr << refinement_log(result);
  if (!flags.quiet) std::cerr << lenses_text(result.lenses) << shutters_text(result.shutters);
}

void print_totals(const BuildFlags& flags, nlohmann::json totals) {
  totals["file"] = file_bytes_json(flags.output);
  if (flags.json_output) {
    print_result(totals, flags.output);
  } else {
    print_result(summary_text(totals, flags.output.string()) + "  on disk " + file_bytes_text(totals["file"]) + '\n',
                 flags.output);
  }
  if (!flags.quiet) {
    std::cerr << next_steps(flags.output, flags.hold.protocol() ? flags.scene : std::filesystem::path());
  }
}

void run(const BuildFlags& flags) {
  BuildOptions options = build_options_of(flags);
  std::optional<EndRequest> end_request;
  take_end_requests(flags, options, end_request);
  const ImageCoding photographs = flags.images.coding();
  check_apart(flags.output, std::array{flags.scene, flags.mesh, flags.pictures.images, flags.pictures.masks});
  ModelOutput output(flags.output);
  const auto shown = flags.view ? std::make_unique<ShownBuild>(page_options_of(flags)) : nullptr;
  const BuildResult result =
      build_model(flags.scene, options, build_progress_of(flags), shown ? shown->watch() : AtlasWatch());
  tell(flags, result);
  const nlohmann::json totals = save_model(result, output, photographs);
  remove_stereo_work(options.completion.stereo_folder);
  print_totals(flags, totals);
  const bool asked_to_end = end_request && end_request->made();
  end_request.reset();
  if (shown && !asked_to_end) shown->show_until_interrupted(result.snapshot);
}

}  // namespace

void add_build_command(CLI::App& program) {
  auto flags = std::make_shared<BuildFlags>();
  CLI::App* command = program.add_subcommand("build", "Choose photographs of a scene and pack them: the main job");
  flags->add_to(*command);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
