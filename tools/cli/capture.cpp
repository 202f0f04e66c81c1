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
      program.add_subcommand("capture", "From photographs or videos to a model: COLMAP's poses, a mesh, and a build");
  add_file(*command, "PHOTOGRAPHS", flags->photographs, "PHOTOGRAPHS",
           "Folder of overlapping photographs and videos of a place, or one video")
      ->required();
  begin_group(*command, "Files");
  add_model_output(*command, flags->output);
  add_file(*command, "--work", flags->work, "DIR",
           "Poses, mesh and COLMAP's logs, which other commands read as a SCENE; what is done there is not done again; "
           "MODEL-capture unless given");
  add_file(*command, "--masks", flags->masks, "DIR",
           "Black where a photograph is not to be used, for poses and colours; of NAME.jpg: NAME.jpg.png or NAME.png");
  command->add_option("--max-frames", flags->options.most_frames, "Photographs that are made of videos, at most")
      ->type_name("N")
      ->transform(whole_number(2, 100'000))
      ->default_str(std::to_string(flags->options.most_frames));
  begin_group(*command, "Poses");
  add_choice(*command, "--matching", flags->options.colmap.matching.matching,
             {{"automatic", Matching::automatic},
              {"exhaustive", Matching::exhaustive},
              {"sequential", Matching::sequential},
              {"spatial", Matching::spatial}},
             "Compare each photograph with each, with its neighbours by name, or by GPS; automatic: with each up to " +
                 std::to_string(kMostForExhaustive) + ", of more with all neighbours that are known");
  add_file(*command, "--vocabulary", flags->vocabulary, "FILE",
           "COLMAP's vocabulary tree: compare photographs that look alike, too");
  command
      ->add_option("--camera-model", flags->options.colmap.camera_model,
                   "Of the lenses, by COLMAP's name, such as OPENCV or OPENCV_FISHEYE")
      ->type_name("NAME")
      ->default_str(flags->options.colmap.camera_model);
  add_choice(*command, "--mapper", flags->options.colmap.mapper,
             {{"incremental", Mapper::incremental}, {"global", Mapper::global}},
             "Place photographs one by one, or all at once, which COLMAP 4 or GLOMAP can");
  add_file(*command, "--poses", flags->poses, "SCENE",
           "A scene of any form that has the poses of these photographs; COLMAP then finds points alone");
  command->add_flag("--gpu", flags->options.colmap.use_gpu, "Let COLMAP use a GPU, if it is built for one");
  begin_group(*command, "Mesh");
  add_choice(*command, "--from", flags->options.mesh.from,
             {{"photographs", MeshSource::photographs}, {"points", MeshSource::points}},
             "Match the photographs for depth, or take the points alone, which is quick; photographs unless --points");
  add_file(*command, "--points", flags->points, "FILE",
           "PLY of denser points to make the mesh of, in the coordinates of the poses in WORK/sparse");
  begin_group(*command, "Model");
  flags->hold.add_to(*command, "Leave out every H-th by name, for `lumatlas validate` to score");
  command->add_option("--max-views", flags->options.build.max_views, "Photographs that it may hold")
      ->type_name("N")
      ->transform(whole_number(1, 1u << 20))
      ->default_str(std::to_string(*flags->options.build.max_views));
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
