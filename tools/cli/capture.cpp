// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/capture.h"

#include <array>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/base/output_folder.h"
#include "tools/capture/capture_json.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/json_output.h"
#include "tools/cli/output/next_steps.h"
#include "tools/cli/output/stage_bars.h"
#include "tools/pipeline/output/build_summary.h"

namespace lumatlas {

namespace {

struct CaptureFlags {
  std::filesystem::path photographs, output, work, masks, points, poses, vocabulary;
  CaptureOptions options;
  HoldFlags hold;
  bool json_output = false;
  bool quiet = false;
};

void run(CaptureFlags flags) {
  if (flags.work.empty()) flags.work = capture_beside(flags.output);
  if (!flags.masks.empty()) flags.options.masks = flags.masks;
  if (!flags.points.empty()) flags.options.mesh.points = flags.points;
  if (!flags.poses.empty()) flags.options.poses = flags.poses;
  if (!flags.vocabulary.empty()) flags.options.colmap.matching.vocabulary = flags.vocabulary;
  flags.options.build.hold_out = flags.hold.protocol();
  check_usage(flags.options);
  check_apart(flags.output,
              std::array{flags.photographs, flags.work, flags.masks, flags.points, flags.poses, flags.vocabulary});
  const bool quiet = flags.quiet;
  const auto say = [quiet](const std::string& sentence) {
    if (!quiet) std::cerr << sentence << '\n';
  };
  const CaptureResult result = capture(flags.photographs, flags.work, flags.output, flags.options,
                                       {say, bars_on_standard_error(quiet), progress_on_standard_error(quiet)});
  for (const std::string& warning : result.warnings) std::cerr << "warning: " << warning << '\n';
  if (flags.json_output) {
    print_result(capture_json(result, flags.work, flags.output), flags.output);
    return;
  }
  if (result.summary.is_object()) print_result(summary_text(result.summary, flags.output.string()), flags.output);
  if (!quiet) std::cerr << next_steps(flags.output, flags.hold.protocol() ? flags.work : std::filesystem::path());
}

}  // namespace

void add_capture_command(CLI::App& program) {
  auto flags = std::make_shared<CaptureFlags>();
  CLI::App* command =
      program.add_subcommand("capture", "Make a model of photographs or videos: poses by COLMAP, a mesh, and a build");
  add_file(*command, "PHOTOGRAPHS", flags->photographs, "PHOTOGRAPHS",
           "Folder of overlapping photographs and videos of a place, or one video")
      ->required();
  begin_group(*command, "Files");
  add_model_output(*command, flags->output);
  add_file(
      *command, "--work", flags->work, "DIR",
      "Folder for poses, mesh and logs of COLMAP; other commands read it as a SCENE, and the next run skips the steps "
      "that are done there; without it MODEL-capture");
  add_file(*command, "--masks", flags->masks, "DIR",
           "Folder of masks: black pixels are used neither for poses nor for colours; the mask of NAME.jpg is "
           "NAME.jpg.png or "
           "NAME.png");
  command->add_option("--max-frames", flags->options.most_frames, "Most frames to take of all videos together")
      ->type_name("N")
      ->transform(whole_number(2, 100'000))
      ->default_str(std::to_string(flags->options.most_frames));
  begin_group(*command, "Poses");
  add_choice(
      *command, "--matching", flags->options.colmap.matching.matching,
      {{"automatic", Matching::automatic},
       {"exhaustive", Matching::exhaustive},
       {"sequential", Matching::sequential},
       {"spatial", Matching::spatial}},
      "Compare each photograph with all others, with its neighbours by name, or by GPS; automatic: with all others "
      "up to " +
          std::to_string(kMostForExhaustive) + " photographs, else with neighbours by name and GPS");
  add_file(*command, "--vocabulary", flags->vocabulary, "FILE",
           "COLMAP's vocabulary tree: also compare photographs that look alike");
  command
      ->add_option("--camera-model", flags->options.colmap.camera_model,
                   "COLMAP's name of the lenses' model, such as OPENCV or OPENCV_FISHEYE")
      ->type_name("NAME")
      ->default_str(flags->options.colmap.camera_model);
  add_choice(*command, "--mapper", flags->options.colmap.mapper,
             {{"incremental", Mapper::incremental}, {"global", Mapper::global}},
             "Place photographs one by one, or all at once (needs COLMAP 4 or GLOMAP)");
  add_file(*command, "--poses", flags->poses, "SCENE",
           "Take the poses from this scene, of any form; COLMAP then finds only points");
  command->add_flag("--gpu", flags->options.colmap.use_gpu, "Let COLMAP use a GPU, if it is built for one");
  begin_group(*command, "Mesh");
  add_choice(
      *command, "--from", flags->options.mesh.from,
      {{"photographs", MeshSource::photographs}, {"points", MeshSource::points}},
      "Make the mesh of depth matched between photographs, or, quickly, of points alone; photographs unless --points");
  add_file(*command, "--points", flags->points, "FILE",
           "PLY of denser points for the mesh, in the coordinates of WORK/sparse");
  begin_group(*command, "Model");
  flags->hold.add_to(*command, "Leave out every H-th photograph, which `validate` scores");
  command->add_option("--max-views", flags->options.build.max_views, "Most photographs to keep")
      ->type_name("N")
      ->transform(whole_number(1, 1u << 20))
      ->default_str(std::to_string(*flags->options.build.max_views));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
