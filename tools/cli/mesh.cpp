// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/file_ending.h"
#include "mesh/base/number_text.h"
#include "mesh/readers/mesh_file.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/mesh_frame_flags.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/cli/output/stage_bars.h"
#include "tools/meshing/length_text.h"
#include "tools/meshing/mesh_json.h"
#include "tools/meshing/scene_mesh.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

// Options and settings, and the sources that use them.
struct SourceOptions {
  std::vector<const CLI::Option*> options;
  std::vector<std::string> settings;
  std::vector<MeshSource> sources;
};

struct MeshFlags {
  std::filesystem::path scene, output, points, complete;
  SceneMeshOptions options;
  SettingFlags<SceneMeshOptions> settings{mesh_settings()};
  MeshFrameFlags mesh_frame;
  HoldFlags hold_out;
  PictureFlags pictures;
  std::vector<SourceOptions> of_some;
  bool json_output = false;
  bool quiet = false;

  // Throws CLI::ValidationError for an option that would be ignored.
  void check_source(MeshSource source) const {
    for (const SourceOptions& some : of_some) {
      if (std::find(some.sources.begin(), some.sources.end(), source) != some.sources.end()) continue;
      std::string meant;
      for (const MeshSource of : some.sources) meant += (meant.empty() ? "" : " and ") + name_of(of);
      const std::string why = "is for " + meant + ", and this mesh is made of " + name_of(source);
      for (const CLI::Option* option : some.options) {
        if (option->count() > 0) throw CLI::ValidationError(option->get_name(), why);
      }
      for (const std::string& setting : some.settings) settings.given().refuse(setting, why);
    }
  }
};

void check_is_ply(const std::filesystem::path& output) {
  if (lower_case_ending(output) != ".ply")
    throw CLI::ValidationError("--output", output.string() + " does not end in .ply");
}

std::string source_text(const SceneMesh& made) {
  if (made.source == MeshSource::photographs) {
    return "from " + std::to_string(made.points_used) + " of " + std::to_string(made.points) + " points that " +
           std::to_string(made.matched) + " photographs agree on\n";
  }
  if (!made.depth) {
    return "from " + std::to_string(made.points_used) + " of " + std::to_string(made.points) + " points of " +
           made.points_file.string() + '\n';
  }
  const DepthFacts& depth = *made.depth;
  return "from " + std::to_string(depth.images) + " depth images in voxels of " + length_text(depth.voxel) +
         " scene units, " + number_text(depth.voxel_px, 1) + " of their pixels\n  " + percent_text(depth.confirmed) +
         " of the depths in sight of another depth image are confirmed by it; " + std::to_string(depth.removed_pieces) +
         " small pieces of " + std::to_string(depth.removed_faces) + " faces were left out\n";
}

std::string completion_text(const SceneMesh& made, const std::filesystem::path& output) {
  const CompletionFacts& completion = *made.completion;
  return output.string() + ": " + completion.file.string() + " and " + std::to_string(completion.added_faces) +
         " faces that " + name_of(made.source) + " show beyond it; " + percent_text(completion.covered) +
         " of the photographs' pixels see a surface, " + percent_text(completion.covered_before) + " before\n";
}

std::string mesh_text(const SceneMesh& made, const std::filesystem::path& output) {
  if (made.completion) return completion_text(made, output);
  const std::string measured = made.depth ? "depth" : "point";
  return output.string() + ": " + std::to_string(made.surface.positions.size()) + " vertices, " +
         std::to_string(made.surface.faces.size()) + " faces, " + source_text(made) + "  " +
         percent_text(made.trust.points_on_surface) + " of the " + measured + "s lie on it, within " +
         number_text(kOnSurfacePx) + " pixels\n  " + percent_text(made.trust.pixels_covered) +
         " of the photographs' pixels see it; of these " + percent_text(made.trust.pixels_guessed) +
         " are a guess, more than " + number_text(kFarFromPointsPx) + " pixels from every " + measured + '\n';
}

void run(MeshFlags flags) {
  if (!flags.points.empty()) flags.options.points = flags.points;
  if (!flags.complete.empty()) flags.options.complete = flags.complete;
  flags.options.complete_frame = flags.mesh_frame.frame().value_or(MeshFrame{});
  flags.options.pictures = flags.pictures.folders();
  flags.settings.apply(flags.options);
  check_usage(flags.options);
  check_is_ply(flags.output);
  check_apart(flags.output, std::array{flags.scene, flags.points, flags.complete});
  const auto start = std::chrono::steady_clock::now();
  flags.options.hold_out = flags.hold_out.protocol();
  flags.options.stereo_folder = flags.output.string() + ".stereo";
  AtomicFile file(flags.output);
  const SceneMesh made = mesh_from_scene(flags.scene, flags.options, bars_on_standard_error(flags.quiet),
                                         [&flags](MeshSource source) { flags.check_source(source); });
  write_ply(file.stream(), made.surface);
  file.commit();
  if (made.source == MeshSource::photographs) remove_stereo_work(flags.options.stereo_folder);
  const double time_ms = ms_since(start);
  for (const std::string& warning : made.warnings) std::cerr << "warning: " << warning << '\n';
  if (flags.json_output) {
    print_result(mesh_json(made, flags.output, time_ms), flags.output);
    return;
  }
  print_result(mesh_text(made, flags.output), flags.output);
  if (!flags.quiet) {
    std::cerr << "use it: "
              << shell_line("lumatlas", {"build", flags.scene.string(), "--mesh", flags.output.string(), "-o", "MODEL"})
              << '\n';
  }
}

}  // namespace

void add_mesh_command(CLI::App& program) {
  auto flags = std::make_shared<MeshFlags>();
  CLI::App* command = program.add_subcommand("mesh", "Make a mesh of a scene's photographs, depth images or points");
  add_file(*command, "SCENE", flags->scene, "SCENE", "COLMAP workspace, or a capture of another form")->required();
  begin_group(*command, "Files");
  add_file(*command, "-o,--output", flags->output, "FILE",
           "PLY; the other commands find SCENE/mesh.ply; an earlier file there is replaced. Until it is written, "
           "FILE.stereo/ beside it keeps finished depth for a run that goes on")
      ->required();
  add_file(*command, "--points", flags->points, "FILE",
           "PLY of points; with --from photographs they limit the depths to search");
  add_file(*command, "--complete", flags->complete, "MESH",
           "Keep this mesh, and add surface only in its holes and beyond its ends");
  flags->pictures.add_to(*command);
  add_choice(
      *command, "--from", flags->options.from,
      {{"photographs", MeshSource::photographs}, {"depth", MeshSource::depth_images}, {"points", MeshSource::points}},
      "Source; without it depth images, else dense points (fused.ply in SCENE or dense/), else photographs");
  begin_group(*command, "From photographs");
  command
      ->add_option("--match-size", flags->options.stereo.longest_px, "Longer side of photographs for matching, pixels")
      ->type_name("PX")
      ->transform(whole_number(64, 8192));
  command->add_option("--neighbors", flags->options.stereo.neighbors, "Number of photographs to match each one with")
      ->type_name("N")
      ->transform(whole_number(1, 16));
  command
      ->add_option("--most-photographs", flags->options.most_photographs,
                   "Most photographs to match, spread evenly by name")
      ->type_name("N")
      ->transform(whole_number(2, 1'000'000));
  flags->hold_out.add_to(*command, "Leave out every H-th photograph, which `validate` scores");
  begin_group(*command, "From depth images");
  command
      ->add_option("--voxel", flags->options.voxel,
                   "Side of a voxel, scene units; without it 1.5 pixels of a depth image")
      ->type_name("LENGTH");
  command
      ->add_option("--depth-unit", flags->options.depth_unit,
                   "Length of one step of a depth image's values, scene units")
      ->type_name("LENGTH");
  command->add_option("--most-faces", flags->options.most_faces, "Most faces; edges are collapsed down to it")
      ->type_name("N")
      ->transform(whole_number(100, 100'000'000));
  begin_group(*command, "From points and photographs");
  command->add_option("--spacing", flags->options.spacing_px, "Merge points closer than this in the nearest photograph")
      ->type_name("PX");
  command->add_option("--most-points", flags->options.most_points, "Most points; --spacing grows to reach it")
      ->type_name("N")
      ->transform(whole_number(4, 100'000'000));
  command
      ->add_option(
          "--longest-edge", flags->options.longest_edge,
          "Leave holes where a face would have an edge longer than N median edges; without it 20, from photographs 30")
      ->type_name("N");
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  begin_rare_group(*command, "--complete with a mesh in another frame than the poses");
  flags->mesh_frame.add_to(*command, command->get_option("--complete"));
  flags->settings.add_to(*command);
  const auto only_of = [&](std::vector<MeshSource> sources, const std::vector<const char*>& names,
                           std::vector<std::string> settings = {}) {
    SourceOptions some{{}, std::move(settings), std::move(sources)};
    for (const char* name : names) some.options.push_back(command->get_option(name));
    flags->of_some.push_back(std::move(some));
  };
  only_of({MeshSource::photographs}, {"--match-size", "--neighbors", "--most-photographs", "--hold"}, {"mesh.block"});
  only_of({MeshSource::depth_images}, {"--depth-unit", "--voxel", "--most-faces"});
  only_of({MeshSource::points}, {}, {"cut.noise"});
  only_of({MeshSource::points, MeshSource::photographs}, {"--points", "--spacing", "--most-points", "--longest-edge"},
          {"cut.quality", "cut.sure-views"});
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
