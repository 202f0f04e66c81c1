// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/render_flags.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "blend/tables/tiles.h"
#include "tools/cli/flags/option_rules.h"
#include "tools/picture/paths/camera_tours.h"
#include "tools/picture/tour_settings.h"
#include "tools/settings/option_tables.h"

namespace lumatlas {

namespace {

const Names<Mode> kModes(kModesByName.begin(), kModesByName.end());

const Names<PictureFormat> kPictureFormats{
    {"png", PictureFormat::png}, {"exr", PictureFormat::exr}, {"mp4", PictureFormat::mp4}};

constexpr std::uint64_t kMostPixelsASide = 65536;

}  // namespace

void RenderFlags::add_cameras_to(CLI::App& command) {
  begin_group(command, "Cameras: give exactly one of these");
  of_scene_ = add_file(command, "--views", views, "SCENE",
                       "Render from the cameras of a scene, at the size of its photographs");
  CLI::Option* const along_keys =
      add_file(command, "--path", path, "FILE", "Move smoothly through the key frames of a JSON file");
  CLI::Option* const around = command.add_flag("--orbit", orbit, "Move once around what the model's views look at");
  CLI::Option* const through =
      command.add_flag("--walk", walk, "Move through the cameras of the model's views, in the order of their names");
  CLI::Option* const along_hilbert =
      command.add_flag("--hilbert", hilbert, "Move along a Hilbert curve over the scene's ground");
  cameras_ = {of_scene_, along_keys, around, through, along_hilbert};
  begin_group(command, "Number and size of the pictures");
  hold.add_to(command, "With --views, only views that `validate --hold H` scores");
  hold.hold_option->needs(of_scene_);
  command.add_option("--frames", frames, "Number of pictures of a path")
      ->type_name("N")
      ->transform(whole_number(1, 1000000))
      ->excludes(of_scene_);
  command.add_option("--width", width, "Width of a path's pictures, pixels")
      ->type_name("PX")
      ->transform(whole_number(1, kMostPixelsASide))
      ->excludes(of_scene_);
  command.add_option("--height", height, "Height of a path's pictures, pixels")
      ->type_name("PX")
      ->transform(whole_number(1, kMostPixelsASide))
      ->excludes(of_scene_);
  command.add_option("--fov", fov_deg, "Horizontal field of view of a path that names none")
      ->type_name("DEGREES")
      ->check(number_between(1, 170))
      ->excludes(of_scene_);
}

void RenderFlags::add_mode_to(CLI::App& command) {
  begin_group(command, "Picture");
  add_choice(command, "--mode", mode, kModes,
             "Draw the picture, or a measure of the model; error, against the photographs, needs --views");
  command.add_option("--range", range, "Values at the two ends of a mode's colour scale; without it the mode's own")
      ->type_name("LEAST MOST")
      ->expected(2)
      ->default_str("");
  command.add_flag("--no-color-bar", no_color_bar, "Leave out the colour scale below a mode's picture");
  command.add_option("--background", background, "Background: blur, alpha, white, #rrggbb")
      ->type_name("NAME")
      ->check([](const std::string& name) {
        return background_named(name) ? std::string() : name + " is none of alpha, blur, black, white or #rrggbb";
      })
      ->default_str("the far sphere");
  blend.add_to(command);
}

void RenderFlags::add_files_to(CLI::App& command) {
  begin_group(command, "Files and messages");
  add_file(command, "-o,--output", output, "DIR", "Folder of the pictures; earlier ones there are replaced")
      ->required();
  add_choice(command, "--format", format, kPictureFormats, "exr has linear light, or a mode's numbers");
  frames_per_second_option_ =
      command.add_option("--fps", frames_per_second, "With --format mp4, by ffmpeg: pictures a second")
          ->type_name("N")
          ->check(number_between(0.01, 1000));
  add_json(command, json_output);
  add_quiet(command, quiet);
  begin_rare_group(command, "time");
  command.add_flag("--verbose", verbose, "Print the time of each step until the first picture");
}

SettingFlags<RenderSettings> RenderFlags::render_settings() {
  return SettingFlags<RenderSettings>(
      joined<RenderSettings>({within<RenderSettings>("path.", tour_settings(), &RenderSettings::tour),
                              within<RenderSettings>("blend.", blend_settings(), &RenderSettings::blend)}));
}

RenderSettings RenderFlags::values() const {
  RenderSettings printed;
  printed.blend = BlendOptions::printed();
  if (blend.paper()) settings.agree_with_paper(printed);
  RenderSettings values;
  values.blend = blend.start();
  settings.apply(values);
  blend.finish(values.blend);
  return values;
}

void RenderFlags::add_to(CLI::App& command) {
  add_file(command, "MODEL", model, "MODEL", "Folder or .glb that `lumatlas build` wrote")->required();
  add_cameras_to(command);
  add_mode_to(command);
  add_files_to(command);
  settings.add_to(command);
}

void RenderFlags::check_cameras() const {
  const auto given =
      std::count_if(cameras_.begin(), cameras_.end(), [](const CLI::Option* option) { return option->count() > 0; });
  if (given == 1) return;
  std::vector<std::string> names;
  for (const CLI::Option* option : cameras_) names.push_back(option->get_name());
  throw CLI::ValidationError(in_words(names), "must be given once, to say from where");
}

void RenderFlags::check() const {
  check_cameras();
  if (mode == Mode::error && views.empty()) {
    throw CLI::ValidationError("--mode", "error needs the photographs of --views");
  }
  if (std::uint64_t{width} * height > kMostPicturePixels) {
    throw CLI::ValidationError("--width", std::to_string(width) + " times --height " + std::to_string(height) +
                                              " is more than 2^30 pixels, name a smaller picture");
  }
  if (!hilbert) settings.given().refuse("path.hilbert-order", "needs --hilbert");
  if (!range.empty() && !has_range(mode)) {
    throw CLI::ValidationError("--range", mode_name() + " has none");
  }
  if (!range.empty() && !(std::isfinite(range[0]) && std::isfinite(range[1]) && range[0] < range[1])) {
    throw CLI::ValidationError("--range", "must be two finite numbers, the smaller one first");
  }
  if (no_color_bar && (mode == Mode::picture || format == PictureFormat::exr)) {
    throw CLI::ValidationError("--no-color-bar",
                               "is for the pictures of another --mode than picture, which have a bar");
  }
  if (!background.empty() && mode != Mode::picture) {
    throw CLI::ValidationError("--background", "is of --mode picture");
  }
  if (background == "alpha" && format == PictureFormat::mp4) {
    throw CLI::ValidationError("--background", "alpha is nothing that a video has: name blur or a colour");
  }
  if (frames_per_second_option_->count() > 0 && format != PictureFormat::mp4) {
    throw CLI::ValidationError("--fps", "needs --format mp4");
  }
}

Background RenderFlags::background_in_use() const {
  if (const auto named = background_named(background)) return *named;
  if (format == PictureFormat::exr) return {Background::Kind::transparent, {}};
  return {};
}

FrameOptions RenderFlags::frame_options() const {
  FrameOptions options;
  options.mode = mode;
  options.blend = values().blend;
  if (!range.empty()) options.range = ValueRange{range[0], range[1]};
  options.color_bar = !no_color_bar;
  options.background = background_in_use();
  return options;
}

TourOptions RenderFlags::tour_options() const {
  TourOptions tour = values().tour;
  tour.kind = !path.empty() ? TourOptions::Kind::keys
              : orbit       ? TourOptions::Kind::orbit
              : walk        ? TourOptions::Kind::walk
                            : TourOptions::Kind::hilbert;
  tour.path = path;
  tour.frames = frames;
  tour.width = width;
  tour.height = height;
  tour.fov_deg = fov_deg;
  return tour;
}

std::string RenderFlags::mode_name() const {
  return name_of(kModes, mode);
}

std::string RenderFlags::format_name() const {
  return name_of(kPictureFormats, format);
}

nlohmann::json RenderFlags::json() const {
  const RenderSettings effective = values();
  nlohmann::json options = blend.json(effective.blend);
  options["settings"] = settings.json(effective);
  options["command"] = "render";
  options["model"] = model.string();
  options["mode"] = mode_name();
  options["format"] = format_name();
  if (!range.empty()) options["range"] = range;
  if (mode != Mode::picture && format != PictureFormat::exr) options["color_bar"] = !no_color_bar;
  if (mode == Mode::picture && !background.empty()) options["background"] = background;
  if (format == PictureFormat::mp4) options["fps"] = frames_per_second;
  if (!views.empty()) {
    options["views"] = views.string();
    return options;
  }
  options["cameras"] = !path.empty() ? "path" : orbit ? "orbit" : walk ? "walk" : "hilbert";
  if (!path.empty()) options["path"] = path.string();
  options["frames"] = frames;
  options["width"] = width;
  options["height"] = height;
  options["fov"] = fov_deg;
  return options;
}

}  // namespace lumatlas
