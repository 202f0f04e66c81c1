// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/model_file.h"
#include "blend/renderer.h"
#include "mesh/errors.h"
#include "tools/blend_flags.h"
#include "tools/commands.h"
#include "tools/output_folder.h"
#include "tools/progress.h"

namespace lumatlas {

namespace {

struct RenderFlags {
  std::filesystem::path model, views, output;
  HoldFlags hold;
  BlendFlags blend;
  bool verbose = false;
  bool quiet = false;
};

double ms_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Where the time until the first picture went.
struct FirstPicture {
  ReadTimes read;
  double upload_ms = 0;   // with the context and its shaders
  double picture_ms = 0;  // drawn, not yet written
  double total_ms = 0;
};

std::string first_picture_text(const FirstPicture& first) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(0) << "first picture after " << first.total_ms << " ms: tables "
       << first.read.tables << ", views " << first.read.views << " (summed over threads: images " << first.read.images
       << ", depth " << first.read.depth << ", masks " << first.read.masks << "), upload " << first.upload_ms
       << ", picture " << first.picture_ms << '\n';
  return text.str();
}

std::vector<std::size_t> ranks_to_render(const SceneViews& scene, const std::optional<HoldOut>& protocol) {
  if (protocol) return split_to_score(scene, *protocol).scored;
  std::vector<std::size_t> ranks(scene.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  return ranks;
}

// Where a view's picture goes: its own name, as PNG. Two photographs may differ in nothing but their ending.
std::filesystem::path picture_path(const SceneView& view, std::set<std::filesystem::path>& taken) {
  std::filesystem::path path = view.name;
  path.replace_extension(".png");
  if (!taken.insert(path).second) {
    path = view.name + ".png";
    taken.insert(path);
  }
  return path;
}

void run(const RenderFlags& flags) {
  const BlendOptions blend = flags.blend.options();
  OutputFolder output(flags.output);
  const auto start = std::chrono::steady_clock::now();
  const Model model = read_model(flags.model);
  const Snapshot& snapshot = model.snapshot;
  FirstPicture first{model.times};
  const SceneViews scene = read_scene_views(flags.views, snapshot.surface->offset);
  const std::vector<std::size_t> ranks = ranks_to_render(scene, flags.hold.protocol());
  const auto read = std::chrono::steady_clock::now();
  const EglContext context;
  if (!flags.quiet) std::cerr << "renderer: " << context.description() << '\n';
  Renderer renderer(context);
  renderer.load(snapshot);
  first.upload_ms = ms_since(read);
  std::set<std::filesystem::path> taken;
  {
    Progress progress("rendering", ranks.size(), ProgressOptions::standard_error(flags.quiet));
    for (const std::size_t rank : ranks) {
      const std::filesystem::path path = output.path() / picture_path(scene.views[rank], taken);
      std::filesystem::create_directories(path.parent_path());
      const auto begin = std::chrono::steady_clock::now();
      const Rendering rendering = renderer.render(scene.views[rank].camera, blend);
      if (first.total_ms == 0) {
        first.picture_ms = ms_since(begin);
        first.total_ms = ms_since(start);
      }
      write_image(path, rendering.picture);
      progress.tick();
    }
  }
  if (flags.verbose && first.total_ms > 0) std::cerr << first_picture_text(first);
  nlohmann::json options = flags.blend.json();
  options["command"] = "render";
  options["model"] = flags.model.string();
  options["views"] = flags.views.string();
  output.commit(options);
  std::cout << flags.output.string() << ": " << ranks.size() << " pictures\n";
}

}  // namespace

void add_render_command(CLI::App& program) {
  auto flags = std::make_shared<RenderFlags>();
  CLI::App* command = program.add_subcommand("render", "Render pictures of a model from given cameras");
  command->add_option("MODEL", flags->model, "Folder or .glb that `lumatlas build` wrote")->required();
  command->add_option("--views", flags->views, "COLMAP workspace whose cameras are rendered, at their size")
      ->required();
  command->add_option("-o,--output", flags->output, "Folder of the pictures; earlier ones there are replaced")
      ->required();
  flags->hold.add_to(*command, "Render only the views that this protocol scores");
  flags->blend.add_to(*command);
  command->add_flag("--verbose", flags->verbose, "Tell where the time until the first picture went");
  command->add_flag("--quiet", flags->quiet, "No progress");
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
