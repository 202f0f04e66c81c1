// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "atlas/model/model_file.h"
#include "mesh/base/errors.h"
#include "tools/base/elapsed.h"
#include "tools/base/output_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/blend_flags.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/cli/output/json_output.h"
#include "tools/lab/timing/frame_size_settings.h"
#include "tools/lab/timing/frame_time.h"
#include "tools/pipeline/offered_scene.h"
#include "tools/pipeline/output/model_output.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/score/report/report_refinements.h"
#include "tools/score/validation.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

using nlohmann::json;

// The structs whose fields --set sets.
struct ValidateSettings {
  BlendOptions blend;
  FrameSize timing;
};

SettingFlags<ValidateSettings> validate_settings() {
  return SettingFlags<ValidateSettings>(joined<ValidateSettings>(
      {within<ValidateSettings>("blend.", blend_settings(), &ValidateSettings::blend),
       within<ValidateSettings>("timing.", frame_size_settings(), &ValidateSettings::timing)}));
}

struct ValidateFlags {
  std::filesystem::path model, views, test, flicker, output;
  PictureFlags pictures;
  HoldFlags hold;
  BlendFlags blend;
  SettingFlags<ValidateSettings> settings = validate_settings();
  std::vector<std::string> baselines{"vertex"};
  bool full = false;
  bool no_alignment = false;
  bool no_pictures = false;
  std::size_t time_frames = 0;  // 0: no frame is timed
  bool json_output = false;
  bool quiet = false;

  // Throws CLI::ValidationError for settings that do not go with the options, std::invalid_argument as check() does.
  [[nodiscard]] ValidateSettings values() const {
    if (time_frames == 0) settings.given().refuse_subject("timing.", "needs --time-frames");
    ValidateSettings values, printed;
    printed.blend = BlendOptions::printed();
    if (blend.paper()) settings.agree_with_paper(printed);
    values.blend = blend.start();
    settings.apply(values);
    blend.finish(values.blend);
    return values;
  }
};

// In the model's folder, or beside its file.
std::filesystem::path report_of(const std::filesystem::path& model) {
  if (std::filesystem::is_directory(model)) return model / "report";
  return model.parent_path() / (model.stem().string() + "-report");
}

// Returns whether a file can be created beside `path`: not without permission, nor on a read-only disk.
bool may_write_beside(const std::filesystem::path& path) {
  const std::filesystem::path parent = path.parent_path();
  return access(parent.empty() ? "." : parent.c_str(), W_OK) == 0;
}

// The protocol that was asked for, else the one that the model was built with: none if it was built from every view, or
// from those that the scene's own list leaves.
std::optional<HoldOut> protocol(const ValidateFlags& flags, const ModelNotes& notes) {
  if (const std::optional<HoldOut> asked = flags.hold.protocol()) return asked;
  if (const std::optional<HoldOut> built = hold_out_of(notes, flags.model)) return built;
  return std::nullopt;
}

// Without a protocol, views to score must come from elsewhere.
void require_views_to_score(const ValidateFlags& flags, const ValidationOptions& options, const SceneViews& scene) {
  if (options.protocol || !flags.test.empty() || held_out_views(scene) > 0) return;
  throw InputError(
      flags.model.string() +
      ": was built from every view, so none is left to score: build it with --hold 8, for example, or name others "
      "with --test");
}

// Frames in the order of their names.
SceneViews read_frames(const std::filesystem::path& folder, const glm::dvec3& offset) {
  SceneViews path = read_scene_views(folder, offset);
  if (path.views.size() < 2) {
    throw InputError(folder.string() + ": has " + std::to_string(path.views.size()) +
                     " frames, flicker needs at least 2: `lumatlas synth --path-frames` writes some");
  }
  return path;
}

// Measures the time to read the model, to load it to a renderer, and to draw it from new places.
json measured_speed(const Model& model, const ValidateFlags& flags, const EglContext& context) {
  const ValidateSettings settings = flags.values();
  const std::vector<Camera> cameras = cameras_between_views(model.snapshot, flags.time_frames, settings.timing);
  if (cameras.empty()) throw InputError(flags.model.string() + ": stores no view, there is no frame to time");
  Renderer renderer;
  const auto start = std::chrono::steady_clock::now();
  renderer.load(model.snapshot);
  const double upload_ms = ms_since(start);
  const FrameTime time = frame_time(renderer, cameras, settings.blend);
  return {{"frames", cameras.size()},
          {"width", settings.timing.width},
          {"height", settings.timing.height},
          {"renderer", context.description()},
          {"read_ms", model.times.tables + model.times.views},
          {"upload_ms", upload_ms},
          {"frame_ms", {{"median", time.wall}, {"p95", time.wall_p95}}},
          {"frame_cpu_ms", {{"median", time.processor}, {"p95", time.processor_p95}}}};
}

std::string speed_text(const json& speed) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << speed["frame_ms"]["median"].get<double>() << " ms ("
       << speed["frame_cpu_ms"]["median"].get<double>() << " ms of processor time), median of " << speed["frames"]
       << " frames of " << speed["width"] << "x" << speed["height"];
  return text.str();
}

// "19.26 dB  0.650", as wide for every figure.
std::string scores_text(const Scores& scores) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << std::setw(8) << scores.psnr << " dB " << std::setprecision(3)
       << std::setw(6) << scores.ssim;
  return text.str();
}

std::string region_text(const std::string& method, const MeanScores& means) {
  std::ostringstream text;
  text << std::left << std::setw(10) << method << std::right << scores_text(means.raw) << scores_text(means.fitted)
       << (means.aligned ? scores_text(*means.aligned) : std::string(18, ' ')) << std::fixed << std::setprecision(1)
       << std::setw(9) << 100 * means.textured << " %";
  return text.str();
}

std::string table_text(const Report& report) {
  const std::vector<MethodScores> means = method_means(report);
  std::ostringstream text;
  text << report.views.size();
  if (report.test.empty() && !report.protocol) {
    text << " views that the scene names for scoring\n";
  } else if (report.test.empty()) {
    text << " held-out views (--hold " << report.protocol->hold << " --block " << report.protocol->block << ")\n";
  } else {
    text << " views of " << report.test << '\n';
  }
  text << "whole frames     raw               fitted            aligned      textured\n";
  for (std::size_t i = 0; i < means.size(); ++i) text << region_text(report.methods[i].name, means[i].frame) << '\n';
  text << "pixels of the mesh                                                             seams  flicker\n"
       << std::fixed << std::setprecision(2);
  for (std::size_t i = 0; i < means.size(); ++i) {
    const ReportMethod& method = report.methods[i];
    text << region_text(method.name, means[i].mesh) << std::setw(9)
         << method.seams.value_or(std::numeric_limits<double>::quiet_NaN());
    if (method.flicker) text << std::setw(9) << method.flicker->rms;
    text << '\n';
  }
  return text.str();
}

json effective_options(const ValidateFlags& flags, const json& protocol, const json& built) {
  const ValidateSettings settings = flags.values();
  json effective = flags.blend.json(settings.blend);
  effective["settings"] = flags.settings.json(settings);
  effective["command"] = "validate";
  effective["views"] = flags.views.string();
  if (!flags.test.empty()) effective["test"] = flags.test.string();
  if (!flags.flicker.empty()) effective["flicker"] = flags.flicker.string();
  effective["protocol"] = protocol;
  effective["built_with"] = built;
  return effective;
}

void run(const ValidateFlags& flags) {
  if (flags.views.empty()) {
    throw CLI::ValidationError("--views",
                               "must name the scene that the model was built from, whose photographs it is "
                               "compared with: `" +
                                   shell_line("lumatlas", {"validate", flags.model.string(), "--views"}) + " SCENE`");
  }
  ValidationOptions options;
  options.blend = flags.values().blend;
  const ModelNotes notes = read_model_notes(flags.model);
  const json& built = notes.options;
  options.protocol = protocol(flags, notes);
  const auto wants = [&](const char* name) {
    if (flags.full && name == std::string("unbounded")) return true;
    return std::find(flags.baselines.begin(), flags.baselines.end(), name) != flags.baselines.end();
  };
  options.unbounded = wants("unbounded");
  options.texture = wants("texture");
  options.vertex = wants("vertex");
  options.aligned = !flags.no_alignment;
  options.pictures = !flags.no_pictures;
  options.quiet = flags.quiet;
  const std::filesystem::path target = flags.output.empty() ? report_of(flags.model) : flags.output;
  check_apart(target, std::array{flags.model, flags.views, flags.flicker, flags.pictures.images, flags.pictures.masks});
  // A model on a disk that is read-only has its scores printed, without a report.
  const bool has_report = !flags.output.empty() || may_write_beside(target);
  std::optional<OutputFolder> output;
  if (has_report) output.emplace(target, "validate");
  options.pictures = options.pictures && has_report;
  const Model model = read_model(flags.model);
  options.validity = model.validity;
  PictureFolders pictures = flags.pictures.folders();
  pictures.skip_bad = skips_bad(notes);
  SceneViews scene = read_scene_views(flags.views, model.snapshot.surface->offset, pictures);
  require_views_to_score(flags, options, scene);
  correct_photographs(scene.views, notes, flags.model);
  if (wants("texture-all")) {
    options.texture_all = offered_photographs(scene, options.protocol, model.validity, notes, flags.model);
  }
  if (!flags.test.empty()) {
    options.test = read_scene_views(flags.test, model.snapshot.surface->offset);
    correct_lenses(options.test->views, notes, flags.model);
  }
  if (!flags.flicker.empty()) options.path = read_frames(flags.flicker, model.snapshot.surface->offset);
  const EglContext context;
  Report report = validate_model(model.snapshot, scene, context, options, has_report ? output->path() : "");
  report.facts.emplace_back("model", flags.model.string());
  report.facts.emplace_back("views stored", std::to_string(model.snapshot.views.size()));
  report.facts.emplace_back("renderer", context.description());
  report.refinements = read_refinements(notes.plan);
  json scores = report_json(report);
  scores["lumatlas"] = LUMATLAS_VERSION;
  if (flags.time_frames > 0) {
    scores["speed"] = measured_speed(model, flags, context);
    report.facts.emplace_back("frame time", speed_text(scores["speed"]));
  }
  if (output) {
    write_report(output->path() / "index.html", report);
    write_json(output->path() / "scores.json", scores);
    output->commit(effective_options(flags, scores["protocol"], built));
  }
  if (flags.json_output) {
    print_result(scores, target);
  } else {
    std::string text = table_text(report);
    if (const std::string sentence = shortfall_sentence(report); !sentence.empty()) text += sentence + '\n';
    if (flags.time_frames > 0) text += "frame time: " + speed_text(scores["speed"]) + '\n';
    print_result(text, target);
  }
  if (flags.quiet) return;
  if (has_report) {
    std::cerr << "report: " << (target / "index.html").string() << '\n';
  } else {
    std::cerr << "no report: " << target.string() << " cannot be written to; name a folder for it with -o\n";
  }
}

void add_timing_to(CLI::App& command, ValidateFlags& flags) {
  begin_rare_group(command, "time");
  command
      .add_option("--time-frames", flags.time_frames,
                  "Also time N frames from between the stored views, and reading and loading the model")
      ->type_name("N")
      ->transform(whole_number(1, 100000))
      ->default_str("");
}

}  // namespace

void add_validate_command(CLI::App& program) {
  auto flags = std::make_shared<ValidateFlags>();
  CLI::App* command = program.add_subcommand("validate", "Score a model on held-out photographs, with an HTML report");
  add_file(*command, "MODEL", flags->model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  begin_group(*command, "Photographs");
  add_file(*command, "--views", flags->views, "SCENE", "The scene that the model was built from");
  flags->pictures.add_to(*command);
  flags->hold.add_to(*command, "Score every H-th view by name; without it, as the model was built");
  add_file(*command, "--test", flags->test, "SCENE",
           "Score all views of this scene instead, as `lumatlas synth --test-views` writes it");
  add_file(*command, "--flicker", flags->flicker, "SCENE",
           "Also measure flicker along its frames, as `lumatlas synth --path-frames` writes them");
  CLI::Option* const baselines =
      command
          ->add_option(
              "--baselines", flags->baselines,
              "Baselines to score too: the textured mesh of `lumatlas export`, the same with --from, all input views "
              "at once, averaged vertex colours")
          ->type_name("NAMES")
          ->check(one_of({"texture", "texture-all", "unbounded", "vertex", "none"}))
          ->delimiter(',')
          ->default_str("vertex");
  command->add_flag("--full", flags->full, "Compare with unbounded too, which takes long: --baselines unbounded,vertex")
      ->excludes(baselines);
  command->add_flag("--no-alignment", flags->no_alignment, "Leave out the aligned score, which takes half of the time");
  begin_group(*command, "Drawing");
  flags->blend.add_to(*command);
  begin_group(*command, "Report and messages");
  add_file(*command, "-o,--output", flags->output, "DIR",
           "Folder of the report; without it report/ in the model, or NAME-report beside NAME.glb");
  command->add_flag("--no-pictures", flags->no_pictures, "Write scores alone, no pictures");
  add_json(*command, flags->json_output);
  add_quiet(*command, flags->quiet);
  add_timing_to(*command, *flags);
  flags->settings.add_to(*command);
  command->callback([flags] { run(*flags); });
}

}  // namespace lumatlas
