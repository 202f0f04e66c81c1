// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/number_text.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/progress.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/json_output.h"
#include "tools/lab/synth/kinds.h"
#include "tools/lab/synth/synth.h"

namespace lumatlas {

namespace {

struct SynthFlags {
  std::string kind, trajectory, district = "1x1";
  std::filesystem::path output;
  SynthOptions options;
  bool json_output = false;
  bool quiet = false;
};

// Returns the numbers of "6x4". Throws CLI::ValidationError.
std::array<std::uint32_t, 2> district_named(const std::string& text) {
  const std::size_t middle = text.find('x');
  const auto number = [&](std::size_t first, std::size_t count) -> std::uint32_t {
    const std::string part = middle == std::string::npos ? "" : text.substr(first, count);
    const bool whole = !part.empty() && part.size() <= 3 &&
                       std::all_of(part.begin(), part.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (!whole) throw CLI::ValidationError("--district", text + " is not two numbers such as 6x4");
    return static_cast<std::uint32_t>(std::stoul(part));
  };
  return {number(0, middle), number(middle + 1, std::string::npos)};
}

void run(SynthFlags flags) {
  const auto start = std::chrono::steady_clock::now();
  flags.options.kind = synth_kind_named(flags.kind);
  if (!flags.trajectory.empty()) flags.options.trajectory = synth_trajectory_named(flags.trajectory);
  flags.options.district = district_named(flags.district);
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
                 {"photographs", o.views},
                 {"width", o.width},
                 {"height", o.height},
                 {"fov", o.fov_deg},
                 {"samples", o.samples},
                 {"triangles", o.triangles},
                 {"district", o.district},
                 {"path_frames", o.path_frames},
                 {"path_step", o.path_step},
                 {"test_views", o.test_views},
                 {"stream_rate", o.stream_rate},
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
  if (flags.json_output) {
    const double time_ms = ms_since(start);
    print_result(nlohmann::json{{"output", flags.output.string()},
                                {"kind", flags.kind},
                                {"photographs", o.views},
                                {"width", o.width},
                                {"height", o.height},
                                {"path_frames", o.path_frames},
                                {"test_views", o.test_views},
                                {"time_ms", {{"total", time_ms}}}},
                 flags.output);
    return;
  }
  print_result(
      flags.output.string() + ": " + std::to_string(o.views) + " photographs of " + size_text(o.width, o.height) + '\n',
      flags.output);
}

void add_disturbances(CLI::App& command, SynthDisturbances& disturbances) {
  begin_rare_group(command, "known errors, listed with the true poses in DIR/truth");
  const auto add = [&](const char* name, double& value, const char* value_name, const char* help) {
    command.add_option(name, value, help)->type_name(value_name);
  };
  add("--pose-noise", disturbances.pose_noise, "PX",
      "Error of the written poses: rms displacement of what a view sees");
  add("--exposure-noise", disturbances.exposure_noise, "EV", "Error of the photographs' exposures, plus or minus");
  add("--white-balance-noise", disturbances.white_balance_noise, "EV",
      "Error of red and blue against green, plus or minus");
  add("--wrong-poses", disturbances.wrong_poses, "SHARE", "Share of the views whose written pose is plainly wrong");
  add("--passers-by", disturbances.passers_by, "SHARE",
      "Share of the photographs with a person who is not in the mesh");
  add("--vignetting", disturbances.vignetting, "SHARE", "Share of the light that is lost in the corners");
  add("--noise", disturbances.noise, "LEVELS", "Noise of the sensor: standard deviation at mid grey, 8-bit levels");
  add("--blur", disturbances.blur, "PX", "Motion of what a view sees while the shutter is open, rms");
  add("--mesh-noise", disturbances.mesh_noise, "LENGTH",
      "Noise of the mesh: displacement along the normal, scene units rms");
  add("--holes", disturbances.holes, "SHARE", "Share of the mesh's area that is cut out in round patches");
  add("--decimate", disturbances.decimate, "SHARE", "Share of the mesh's faces that edge collapses leave");
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
  command->add_option("KIND", flags->kind, described)
      ->required()
      ->type_name("KIND")
      ->check(one_of(kinds).description(""));
  const auto count = [&](const char* name, auto& value, const char* value_name, const char* help) {
    command->add_option(name, value, help)->type_name(value_name)->transform(whole_number(0).description(""));
  };
  SynthOptions& options = flags->options;
  begin_group(*command, "Files");
  add_file(*command, "-o,--output", flags->output, "DIR", "Folder of the scene; an earlier one there is replaced")
      ->required();
  begin_group(*command, "Photographs");
  count("--photographs", options.views, "N", "Number of photographs");
  command->add_option("--trajectory", flags->trajectory, "Path along which they are taken")
      ->type_name("NAME")
      ->check(one_of(names_of_trajectories()))
      ->default_str("hilbert in the village, walk elsewhere");
  count("--width", options.width, "PX", "Width of a photograph");
  count("--height", options.height, "PX", "Height of a photograph");
  command->add_option("--fov", options.fov_deg, "Horizontal field of view")->type_name("DEGREES");
  count("--samples", options.samples, "N", "Light paths a pixel");
  begin_group(*command, "Mesh");
  count("--triangles", options.triangles, "N", "Approximate number of triangles");
  count("--seed", options.seed, "N", "Seed of shapes, patterns and the grain of the photographs");
  command->add_option("--district", flags->district, "Number of different villages side by side, along x and y")
      ->type_name("NxM");
  begin_group(*command, "Truth to score against");
  count("--path-frames", options.path_frames, "N",
        "Also write DIR/path, consecutive frames of a smooth path, for `lumatlas validate --flicker`");
  command->add_option("--path-step", options.path_step, "Distance between the frames of the path, scene units")
      ->type_name("LENGTH");
  count("--test-views", options.test_views, "N",
        "Also write DIR/test, views of random poses, for `lumatlas validate --test`");
  begin_group(*command, "Stream");
  command
      ->add_option("--stream", options.stream_rate,
                   "Also write DIR/stream, a TUM RGB-D folder of RATE frames a second, for `lumatlas live`")
      ->type_name("RATE");
  begin_group(*command, "Messages");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  add_disturbances(*command, flags->options.disturbances);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
