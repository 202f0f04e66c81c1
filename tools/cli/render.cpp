// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/model/model_file.h"
#include "blend/gl/egl_context.h"
#include "blend/renderer.h"
#include "mesh/base/errors.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/progress.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/render_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/picture/model_tour.h"
#include "tools/picture/paths/kept_path.h"
#include "tools/pipeline/refinement/lens_notes.h"

namespace lumatlas {

namespace {

// Wall time since the command began, and where it went until the first picture, which is printed if it is `told`.
class FirstPicture {
 public:
  explicit FirstPicture(bool told) : told_(told) {}

  [[nodiscard]] double total_ms() const { return total_ms_; }

  void has_read(const ReadTimes& times) { read_ = times; }
  void begins_to_load() { load_start_ = Clock::now(); }
  void has_loaded() { load_ms_ = ms_since(load_start_); }
  // Called for every picture; the first counts.
  void is_drawn() {
    if (total_ms_ > 0) return;
    total_ms_ = ms_since(start_);
    if (told_) std::cerr << text(total_ms_);
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] std::string text(double total_ms) const {
    std::ostringstream text;
    text << std::fixed << std::setprecision(0) << "first picture after " << total_ms << " ms: tables " << read_.tables
         << ", views " << read_.views << " (summed over threads: images " << read_.images << ", depth " << read_.depth
         << ", masks " << read_.masks << "), upload " << load_ms_ << '\n';
    return text.str();
  }

  bool told_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point load_start_ = start_;
  ReadTimes read_;
  double load_ms_ = 0;  // with the context and its shaders
  double total_ms_ = 0;
};

struct Shot {
  Camera camera;
  std::filesystem::path file;     // in the output folder
  std::optional<SceneView> view;  // whose camera it is
};

std::vector<Shot> shots_of_scene(const RenderFlags& flags, const Snapshot& snapshot, PictureOutput& output) {
  const ModelNotes notes = read_model_notes(flags.model);
  PictureFolders pictures;
  pictures.skip_bad = skips_bad(notes);
  SceneViews scene = read_scene_views(flags.views, snapshot.surface->offset, pictures);
  correct_photographs(scene.views, notes, flags.model);
  std::vector<std::size_t> ranks(scene.views.size());
  std::iota(ranks.begin(), ranks.end(), std::size_t{0});
  if (const auto protocol = flags.hold.protocol()) ranks = split_to_score(scene, *protocol).scored;
  leave_out_bad(scene, ranks);
  std::vector<Shot> shots;
  for (const std::size_t rank : ranks) {
    const SceneView& view = scene.views[rank];
    shots.push_back({view.camera, output.file_for_view(view.name), view});
  }
  return shots;
}

KeptPath tour_of(const RenderFlags& flags, const Snapshot& snapshot) {
  if (flags.path.empty() && stored_cameras(snapshot).empty()) {
    throw InputError(flags.model.string() + ": holds no views that say where to fly: give key frames (--path)");
  }
  return model_tour(snapshot, flags.tour_options());
}

// Tells people what became of a path that keeps to the photographs.
std::string kept_text(const KeptPath& kept, std::size_t frames) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(0) << "path: " << 100 * kept.covered << "% of the frames show about as much "
       << "as photographs do";
  if (kept.arc_deg < 360) {
    text << "; it swings to and fro over " << kept.arc_deg << " degrees, for of a full circle it would be "
         << 100 * kept.covered_before << "%";
  } else if (kept.moved > 0) {
    text << "; " << kept.moved << " of " << frames << " were moved towards these, before it was "
         << 100 * kept.covered_before << "%";
  }
  text << '\n';
  return text.str();
}

std::vector<Shot> shots_of_path(const RenderFlags& flags, const KeptPath& path, const PictureOutput& output) {
  std::vector<Shot> shots;
  for (const Vantage& vantage : path.vantages) {
    shots.push_back({camera_at(vantage, flags.width, flags.height), output.file_for_frame(shots.size(), flags.frames),
                     std::nullopt});
  }
  return shots;
}

void render(const RenderFlags& flags, const std::vector<Shot>& shots, FrameRenderer& frames, PictureOutput& output,
            FirstPicture& first) {
  Progress progress("rendering", shots.size(), ProgressOptions::standard_error(flags.quiet));
  for (const Shot& shot : shots) {
    std::optional<Photograph> photograph;
    if (flags.mode == Mode::error) photograph = load_photograph(*shot.view);
    const Photograph* const compared = photograph ? &*photograph : nullptr;
    if (flags.format == PictureFormat::exr) {
      const auto numbers = frames.numbers(shot.camera, compared);
      first.is_drawn();
      output.write(shot.file, numbers);
    } else {
      const auto picture = frames.picture(shot.camera, compared);
      first.is_drawn();
      output.write(shot.file, picture);
    }
    progress.tick();
  }
}

void run(const RenderFlags& flags) {
  const auto start = std::chrono::steady_clock::now();
  flags.check();
  const FrameOptions options = flags.frame_options();
  check_apart(flags.output, std::array{flags.model, flags.views, flags.path});
  OutputFolder folder(flags.output, "render");
  PictureOutput output(folder.path(), flags.format, flags.frames_per_second);
  FirstPicture first(flags.verbose);
  const Model model = read_model(flags.model);
  const Snapshot& snapshot = model.snapshot;
  const Snapshot drawn = flags.background.empty() ? snapshot : without_far_sphere(snapshot);
  first.has_read(model.times);
  const bool is_laid = flags.orbit || flags.hilbert;
  const KeptPath path = flags.views.empty() ? tour_of(flags, snapshot) : KeptPath();
  if (is_laid && !flags.quiet) std::cerr << kept_text(path, flags.frames);
  const std::vector<Shot> shots =
      flags.views.empty() ? shots_of_path(flags, path, output) : shots_of_scene(flags, snapshot, output);
  std::optional<EglContext> context;
  std::optional<Renderer> renderer;
  first.begins_to_load();
  if (needs_renderer(flags.mode)) {
    context.emplace();
    if (!flags.quiet) std::cerr << "renderer: " << context->description() << '\n';
    renderer.emplace();
    renderer->load(drawn);
  }
  first.has_loaded();
  FrameRenderer frames(drawn, options, renderer ? &*renderer : nullptr);
  render(flags, shots, frames, output, first);
  output.finish();
  folder.commit(flags.json());
  if (flags.json_output) {
    print_result(nlohmann::json{{"output", flags.output.string()},
                                {"pictures", shots.size()},
                                {"mode", flags.mode_name()},
                                {"format", flags.format_name()},
                                {"path", is_laid ? nlohmann::json{{"covered", path.covered}, {"moved", path.moved}}
                                                 : nlohmann::json()},
                                {"renderer", context ? nlohmann::json(context->description()) : nlohmann::json()},
                                {"time_ms", {{"total", ms_since(start)}, {"first_picture", first.total_ms()}}}},
                 flags.output);
    return;
  }
  print_result(flags.output.string() + ": " + std::to_string(shots.size()) +
                   (flags.format == PictureFormat::mp4 ? " pictures in one video\n" : " pictures\n"),
               flags.output);
}

}  // namespace

void add_render_command(CLI::App& program) {
  auto flags = std::make_shared<RenderFlags>();
  CLI::App* command = program.add_subcommand(
      "render", "Render pictures or a video of a model, or maps of its measures, from given cameras or along a path");
  flags->add_to(*command);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
