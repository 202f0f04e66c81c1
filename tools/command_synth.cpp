// SPDX-License-Identifier: GPL-3.0-or-later
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/commands.h"
#include "tools/output_folder.h"
#include "tools/progress.h"
#include "tools/synth.h"

namespace lumatlas {

namespace {

struct SynthFlags {
  std::string kind;
  std::filesystem::path output;
  SynthOptions options;
  bool quiet = false;
};

void run(const SynthFlags& flags) {
  check_usage(flags.options);
  OutputFolder output(flags.output);
  {
    Progress progress("tracing photographs", flags.options.views, ProgressOptions::standard_error(flags.quiet));
    write_synthetic_scene(flags.options, output.path(), [&] { progress.tick(); });
  }
  const SynthOptions& o = flags.options;
  output.commit({{"command", "synth"},
                 {"kind", flags.kind},
                 {"seed", o.seed},
                 {"views", o.views},
                 {"width", o.width},
                 {"height", o.height},
                 {"fov", o.fov_deg},
                 {"samples", o.samples},
                 {"triangles", o.triangles}});
  std::cout << flags.output.string() << ": " << o.views << " photographs of " << o.width << "x" << o.height << '\n';
}

}  // namespace

void add_synth_command(CLI::App& program) {
  auto flags = std::make_shared<SynthFlags>();
  CLI::App* command = program.add_subcommand("synth", "Make a scene with exact ground truth, in COLMAP's format");
  command->add_option("KIND", flags->kind, "apartment: two furnished rooms with glossy floors")
      ->required()
      ->check(CLI::IsMember({"apartment"}));
  command->add_option("-o,--output", flags->output, "Folder of the scene; an earlier one there is replaced")
      ->required();
  command->add_option("--seed", flags->options.seed, "Furniture, patterns and the grain of the photographs");
  command->add_option("--views", flags->options.views, "Photographs along the walk");
  command->add_option("--width", flags->options.width, "Pixels");
  command->add_option("--height", flags->options.height, "Pixels");
  command->add_option("--fov", flags->options.fov_deg, "Horizontal field of view, degrees");
  command->add_option("--samples", flags->options.samples, "Light paths per pixel");
  command->add_option("--triangles", flags->options.triangles, "Of the mesh, about");
  command->add_flag("--quiet", flags->quiet, "No progress");
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
