// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/build_flags.h"

#include "tools/cli/flags/cell_flags.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/pipeline/build_settings.h"
#include "tools/pipeline/model_budget.h"

namespace lumatlas {

namespace {

const Names<RefineMode> kRefinements{{"none", RefineMode::none},
                                     {"exposure", RefineMode::exposure},
                                     {"pose", RefineMode::pose},
                                     {"all", RefineMode::all},
                                     {"joint", RefineMode::joint}};

// The program compresses tiles where a budget asks for it.
BuildOptions default_options() {
  BuildOptions options;
  options.tight_tiles = compressed_tiles(options.tiles);
  return options;
}

}  // namespace

BuildFlags::BuildFlags() : options(default_options()), settings(build_settings(), default_options()) {}

void BuildFlags::add_files_to(CLI::App& command) {
  add_file(command, "SCENE", scene, "SCENE",
           "COLMAP workspace or other capture with a mesh; --watch: one that fills up")
      ->required();
  begin_group(command, "Files");
  add_model_output(command, output);
  add_file(command, "--mesh", mesh, "FILE",
           "PLY, OBJ, STL or GLB, else looked for in SCENE; in other units, axes or shifted: see "
           "--mesh-scale, --mesh-axes and --mesh-shift in --help-all");
  command.add_flag("--mesh-as-given", mesh_as_given,
                   "Use all faces of the mesh and no others: fill no hole, remove nothing");
  images.add_to(command);
}

void BuildFlags::add_stream_to(CLI::App& command) {
  begin_group(command, "Photographs");
  pictures.add_to(command);
  command.add_flag("--skip-bad", skip_bad, "Go on without those that are missing or damaged, and name them");
  command.add_flag("--watch", watch, "Go on as photographs and poses come into SCENE; Ctrl-C saves the model");
  hold.add_to(command, "Leave out every H-th photograph, which `validate` scores");
}

void BuildFlags::add_model_to(CLI::App& command) {
  begin_group(command, "Model");
  max_views = command.add_option("--max-views", options.max_views, "Most photographs to keep")
                  ->type_name("N")
                  ->transform(whole_number(1, 1u << 20))
                  ->default_str(std::to_string(*options.max_views) + ", with --budget as many as fit");
  budget = command
               .add_option("--budget", budget_size,
                           "Most GPU memory for the model, with its mesh (512MiB, 300MB), or for its photographs "
                           "alone (40Mtexels); auto: as little as --loss allows")
               ->type_name("SIZE")
               ->check(byte_or_texel_size({kAuto}))
               ->default_str("");
  loss =
      command.add_option("--loss", loss_db, "With --budget auto, most PSNR to lose against a model of all photographs")
          ->type_name("DB")
          ->check(finite_not_negative());
  add_cell_size(command, options.cells);
  command.add_option("--faces", faces, "Target face count: a number, keep (all), or auto (as many as pictures show)")
      ->type_name("N")
      ->transform(count_or({kAuto, kKeep}))
      ->default_str("keep; with a --budget of bytes auto");
  refine =
      add_choice(command, "--refine", options.refine, kRefinements,
                 "Correct exposures, poses, or all with lenses and masks; joint: all, then all photographs together");
  command.add_flag("--paper", paper, "Use the paper's measures, masks and mesh, and --refine all unless given");
}

void BuildFlags::add_messages_to(CLI::App& command) {
  begin_group(command, "Messages");
  add_json(command, json_output);
  command.add_flag("--verbose", verbose, "Print for each view how its pose and exposure were corrected");
  command.add_flag("--view", view, "Show the model in the browser while it is built, and until Ctrl-C");
  add_quiet(command, quiet);
}

void BuildFlags::add_rare_mesh_options_to(CLI::App& command) {
  begin_rare_group(command, "a mesh in another frame than the poses, or with holes; a place on the Earth");
  mesh_frame.add_to(command);
  georeference.add_to(command);
  command.add_flag(
      "--any-mesh", options.any_mesh,
      "Build even if most photographs see next to nothing of the mesh, or if it is certainly in another frame");
  command.add_option("--close-holes", options.close_holes, "Close holes of the mesh up to this across, scene units")
      ->type_name("LENGTH")
      ->check(finite_not_negative());
}

void BuildFlags::add_rare_model_options_to(CLI::App& command) {
  begin_rare_group(command, "memory, texture and GPU");
  photograph_bytes =
      command
          .add_option(
              "--photograph-bytes", options.planner.max_bytes,
              "Most bytes for the pixels of stored photographs; with --budget and without --max-views four times "
              "the budget")
          ->type_name("SIZE")
          ->transform(byte_size())
          ->default_str("");
  command
      .add_option("--memory", options.memory.bytes,
                  "Main memory for photographs and masks while the model is built; scratch files in TMPDIR, else "
                  "beside the model, take the rest")
      ->type_name("SIZE")
      ->transform(byte_size())
      ->default_str("half of what is free");
  command
      .add_option(
          "--texture", texture,
          "The longest side of the texture that other programs show in place of averaged colours; none: without")
      ->type_name("PX")
      ->transform(count_or({kNoTexture}));
  add_choice(command, "--visibility-by", options.visibility_by,
             {{"rays", VisibilityBy::rays}, {"gl", VisibilityBy::gl}},
             "Find the visible surface by rays on the processor, or by OpenGL on the GPU");
}

void BuildFlags::add_rare_watch_options_to(CLI::App& command) {
  begin_rare_group(command, "scenes that fill up, and a page that shows it");
  CLI::Option* const watches = command.get_option("--watch");
  CLI::Option* const views = command.get_option("--view");
  command
      .add_option("--idle", idle_s,
                  "With --watch, end and save once nothing has changed for so long; 0: by Ctrl-C alone")
      ->type_name("SECONDS")
      ->transform(whole_number(0, 1u << 20))
      ->needs(watches);
  command.add_option("--port", server.port, "With --view, listen at this port; 0: any that is free")
      ->type_name("N")
      ->transform(whole_number(0, 65535))
      ->needs(views);
  command.add_flag("--no-browser", no_browser, "With --view, only say the address")->needs(views);
}

void BuildFlags::add_to(CLI::App& command) {
  add_files_to(command);
  add_stream_to(command);
  add_model_to(command);
  add_messages_to(command);
  add_rare_mesh_options_to(command);
  add_rare_model_options_to(command);
  add_rare_watch_options_to(command);
  settings.add_to(command);
}

}  // namespace lumatlas
