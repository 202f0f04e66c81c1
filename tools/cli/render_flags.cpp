// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/render_flags.h"

#include <cmath>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/cli/number_flags.h"
#include "tools/paths/camera_tours.h"

namespace lumatlas {

namespace {

constexpr std::uint64_t kMostPixels =
    1u << 30;  // of a picture, which is in memory as a whole, with its depth and states

const std::map<std::string, Mode>& modes() {
  static const std::map<std::string, Mode> names = {{"picture", Mode::picture},
                                                    {"coverage", Mode::coverage},
                                                    {"references", Mode::references},
                                                    {"valid-views", Mode::valid_views},
                                                    {"winner", Mode::winner},
                                                    {"weights", Mode::weights},
                                                    {"cells", Mode::cells},
                                                    {"depth", Mode::depth},
                                                    {"error", Mode::error}};
  return names;
}

const std::map<std::string, PictureFormat>& formats() {
  static const std::map<std::string, PictureFormat> names = {
      {"png", PictureFormat::png}, {"exr", PictureFormat::exr}, {"mp4", PictureFormat::mp4}};
  return names;
}

template <typename Value>
std::string name_of(const std::map<std::string, Value>& names, Value value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return {};
}

}  // namespace

void RenderFlags::add_cameras_to(CLI::App& command) {
  CLI::Option_group* cameras = command.add_option_group("Cameras", "From where: exactly one of these");
  CLI::Option* of_scene =
      cameras->add_option("--views", views, "COLMAP workspace whose cameras are rendered, at their size");
  cameras->add_option("--path", path, "JSON file with key frames, which the camera moves through smoothly");
  cameras->add_flag("--orbit", orbit, "Once around what the model's views look at");
  cameras->add_flag("--walk", walk, "Through the cameras of the model's views, in the order of their names");
  CLI::Option* curve = cameras->add_flag("--hilbert", hilbert, "Along a Hilbert curve over the scene's ground");
  cameras->require_option(1);
  hold.add_to(command, "With --views: render only the views that this protocol scores");
  hold.hold_option->needs(of_scene);
  command.add_option("--hilbert-order", hilbert_order, "With --hilbert: the curve has 2^order turns a side")
      ->check(CLI::Range(1u, kMostHilbertOrder))
      ->needs(curve);
  command.add_option("--frames", frames, "Of a path: how many pictures, at equal times or distances")
      ->check(CLI::Range(std::size_t{1}, std::size_t{1000000}))
      ->excludes(of_scene);
  command.add_option("--width", width, "Of a path: pixels")->check(CLI::Range(1u, 65536u))->excludes(of_scene);
  command.add_option("--height", height, "Of a path: pixels")->check(CLI::Range(1u, 65536u))->excludes(of_scene);
  command
      .add_option("--fov", fov_deg,
                  "Of a path: horizontal field of view, degrees; of the key frames in a file that name none")
      ->check(number_between(1, 170))
      ->excludes(of_scene);
}

void RenderFlags::add_mode_to(CLI::App& command) {
  command
      .add_option(
          "--mode", mode,
          "What is shown: picture; coverage or references of each cell; at each pixel the number of valid-views, "
          "the winner among them or the weights of the three best; cells, depth; or, with --views, the error "
          "against the photograph")
      ->transform(CLI::CheckedTransformer(modes()).description(
          "{picture,coverage,references,valid-views,winner,weights,cells,depth,error}"))
      ->default_str("picture");
  command
      .add_option("--range", range,
                  "Of the colours, two numbers, for --mode coverage, references, valid-views, depth and error; without "
                  "it the mode's own, the same for all pictures of a model")
      ->expected(2)
      ->default_str("");
  command.add_flag("--no-color-bar", no_color_bar,
                   "Leave out the bar below a mode's picture, which says what it means");
  blend.add_to(command);
}

void RenderFlags::add_files_to(CLI::App& command) {
  command
      .add_option("--format", format,
                  "png; exr (linear light, or a mode's numbers as they are); or mp4 (one video, by the program ffmpeg)")
      ->transform(CLI::CheckedTransformer(formats()).description("{png,exr,mp4}"))
      ->default_str("png");
  frames_per_second_option = command.add_option("--fps", frames_per_second, "With --format mp4: pictures per second")
                                 ->check(number_between(0.01, 1000));
  command.add_flag("--verbose", verbose, "Tell where the time until the first picture went");
  command.add_flag("--quiet", quiet, "No progress");
}

void RenderFlags::add_to(CLI::App& command) {
  command.add_option("MODEL", model, "Folder or .glb that `lumatlas build` wrote")->required();
  command.add_option("-o,--output", output, "Folder of the pictures; earlier ones there are replaced")->required();
  add_cameras_to(command);
  add_mode_to(command);
  add_files_to(command);
}

void RenderFlags::check() const {
  if (mode == Mode::error && views.empty()) {
    throw CLI::ValidationError("--mode", "error needs the photographs of --views");
  }
  if (std::uint64_t{width} * height > kMostPixels) {
    throw CLI::ValidationError("--width", std::to_string(width) + " times --height " + std::to_string(height) +
                                              " is more than 2^30 pixels, name a smaller picture");
  }
  if (!range.empty() && !has_range(mode)) {
    throw CLI::ValidationError("--range", name_of(modes(), mode) + " has none");
  }
  if (!range.empty() && !(std::isfinite(range[0]) && std::isfinite(range[1]) && range[0] < range[1])) {
    throw CLI::ValidationError("--range", "must be two finite numbers, the smaller one first");
  }
  if (frames_per_second_option->count() > 0 && format != PictureFormat::mp4) {
    throw CLI::ValidationError("--fps", "needs --format mp4");
  }
}

FrameOptions RenderFlags::frame_options() const {
  FrameOptions options;
  options.mode = mode;
  options.blend = blend.options();
  if (!range.empty()) options.range = ValueRange{range[0], range[1]};
  options.color_bar = !no_color_bar;
  return options;
}

nlohmann::json RenderFlags::json() const {
  nlohmann::json options = blend.json();
  options["command"] = "render";
  options["model"] = model.string();
  options["mode"] = name_of(modes(), mode);
  options["format"] = name_of(formats(), format);
  if (!range.empty()) options["range"] = range;
  if (mode != Mode::picture && format != PictureFormat::exr) options["color_bar"] = !no_color_bar;
  if (format == PictureFormat::mp4) options["fps"] = frames_per_second;
  if (!views.empty()) {
    options["views"] = views.string();
    return options;
  }
  options["cameras"] = !path.empty() ? "path" : orbit ? "orbit" : walk ? "walk" : "hilbert";
  if (!path.empty()) options["path"] = path.string();
  if (hilbert) options["hilbert_order"] = hilbert_order;
  options["frames"] = frames;
  options["width"] = width;
  options["height"] = height;
  options["fov"] = fov_deg;
  return options;
}

}  // namespace lumatlas
