// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/base/output_folder.h"
#include "tools/base/progress.h"
#include "tools/cli/commands.h"
#include "tools/synth/kinds.h"
#include "tools/synth/synth.h"

namespace lumatlas {

namespace {

struct SynthFlags {
  std::string kind, trajectory;
  std::filesystem::path output;
  SynthOptions options;
  bool quiet = false;
};

void run(SynthFlags flags) {
  flags.options.kind = synth_kind_named(flags.kind);
  if (!flags.trajectory.empty()) flags.options.trajectory = synth_trajectory_named(flags.trajectory);
  check_usage(flags.options);
  OutputFolder output(flags.output, "synth");
  {
    Progress progress("tracing photographs", flags.options.views + flags.options.path_frames + flags.options.test_views,
                      ProgressOptions::standard_error(flags.quiet));
    write_synthetic_scene(flags.options, output.path(), [&] { progress.tick(); });
  }
  const SynthOptions& o = flags.options;
  output.commit({{"command", "synth"},
                 {"kind", flags.kind},
                 {"trajectory", synth_trajectory(o).name},
                 {"seed", o.seed},
                 {"views", o.views},
                 {"width", o.width},
                 {"height", o.height},
                 {"fov", o.fov_deg},
                 {"samples", o.samples},
                 {"triangles", o.triangles},
                 {"path_frames", o.path_frames},
                 {"path_step", o.path_step},
                 {"test_views", o.test_views},
                 {"pose_noise", o.disturbances.pose_noise},
                 {"exposure_noise", o.disturbances.exposure_noise},
                 {"white_balance_noise", o.disturbances.white_balance_noise},
                 {"wrong_poses", o.disturbances.wrong_poses},
                 {"passers_by", o.disturbances.passers_by},
                 {"vignetting", o.disturbances.vignetting},
                 {"noise", o.disturbances.noise},
                 {"blur", o.disturbances.blur},
                 {"mesh_noise", o.disturbances.mesh_noise},
                 {"holes", o.disturbances.holes},
                 {"decimate", o.disturbances.decimate}});
  std::cout << flags.output.string() << ": " << o.views << " photographs of " << o.width << "x" << o.height << '\n';
}

void add_disturbances(CLI::App& command, SynthDisturbances& disturbances) {
  const std::string group = "Known errors, listed with the true poses in DIR/truth";
  const auto add = [&](const char* name, double& value, const char* help) {
    command.add_option(name, value, help)->group(group);
  };
  add("--pose-noise", disturbances.pose_noise, "Of the written poses: displacement of what a view sees, pixels rms");
  add("--exposure-noise", disturbances.exposure_noise, "Of the photographs, +- EV");
  add("--white-balance-noise", disturbances.white_balance_noise, "Of red and blue against green, +- EV");
  add("--wrong-poses", disturbances.wrong_poses, "Share of the views whose written pose is plainly wrong");
  add("--passers-by", disturbances.passers_by, "Share of the photographs with a person who is not in the mesh");
  add("--vignetting", disturbances.vignetting, "Share of the light that is lost in the corners");
  add("--noise", disturbances.noise, "Of the sensor: standard deviation at mid grey, 8-bit levels");
  add("--blur", disturbances.blur, "Motion of what a view sees while the shutter is open, pixels rms");
  add("--mesh-noise", disturbances.mesh_noise, "Of the mesh: displacement along the normal, scene units rms");
  add("--holes", disturbances.holes, "Share of the mesh's area that is cut out in round patches");
  add("--decimate", disturbances.decimate, "Share of the mesh's faces that is left by edge collapses");
}

// Their names, and what the help says of each.
std::pair<std::vector<std::string>, std::string> names_of_kinds() {
  std::vector<std::string> names;
  std::string described;
  for (const SynthKindRow& row : synth_kinds()) {
    names.emplace_back(row.name);
    described += (described.empty() ? "" : "; ") + names.back() + ": " + row.description;
  }
  return {names, described};
}

std::vector<std::string> names_of_trajectories() {
  std::vector<std::string> names;
  for (const SynthTrajectoryRow& row : synth_trajectories()) names.emplace_back(row.name);
  return names;
}

}  // namespace

void add_synth_command(CLI::App& program) {
  auto flags = std::make_shared<SynthFlags>();
  CLI::App* command = program.add_subcommand("synth", "Make a scene with exact ground truth, in COLMAP's format");
  const auto [kinds, described] = names_of_kinds();
  command->add_option("KIND", flags->kind, described)->required()->check(CLI::IsMember(kinds));
  command->add_option("-o,--output", flags->output, "Folder of the scene; an earlier one there is replaced")
      ->required();
  command->add_option("--seed", flags->options.seed, "Shapes, patterns and the grain of the photographs");
  command->add_option("--views", flags->options.views, "Photographs along the trajectory");
  command
      ->add_option("--trajectory", flags->trajectory,
                   "Where the photographs are taken; without it, hilbert in the village, walk elsewhere")
      ->check(CLI::IsMember(names_of_trajectories()));
  command->add_option("--width", flags->options.width, "Pixels");
  command->add_option("--height", flags->options.height, "Pixels");
  command->add_option("--fov", flags->options.fov_deg, "Horizontal field of view, degrees");
  command->add_option("--samples", flags->options.samples, "Light paths per pixel");
  command->add_option("--triangles", flags->options.triangles, "Of the mesh, about");
  command->add_option("--path-frames", flags->options.path_frames,
                      "Also write DIR/path: so many consecutive frames of a smooth path with their true pictures");
  command->add_option("--path-step", flags->options.path_step, "Between the frames of the path, scene units");
  command->add_option(
      "--test-views", flags->options.test_views,
      "Also write DIR/test: so many views of random poses with their true pictures, for `validate --test`");
  add_disturbances(*command, flags->options.disturbances);
  command->add_flag("--quiet", flags->quiet, "No progress");
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
