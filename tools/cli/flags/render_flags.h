// SPDX-License-Identifier: GPL-3.0-or-later
// The options of `lumatlas render`: from where, what is shown, and as which files.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/cli/commands.h"
#include "tools/cli/flags/blend_flags.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/picture/frame_renderer.h"
#include "tools/picture/model_tour.h"
#include "tools/picture/picture_output.h"

namespace lumatlas {

// The structs whose fields --set sets.
struct RenderSettings {
  BlendOptions blend;
  TourOptions tour;
};

struct RenderFlags {
  std::filesystem::path model, output;
  // The cameras: exactly one of these is given.
  std::filesystem::path views, path;
  bool orbit = false, walk = false, hilbert = false;
  HoldFlags hold;
  std::size_t frames = 120;
  std::uint32_t width = 1280, height = 720;  // pixels
  double fov_deg = 70;
  // The quantity that pictures show.
  Mode mode = Mode::picture;
  std::vector<double> range;  // none, or least and most
  bool no_color_bar = false;
  std::string background;  // empty: blur, or alpha in an OpenEXR file
  BlendFlags blend;
  SettingFlags<RenderSettings> settings = render_settings();
  // The form of the files.
  PictureFormat format = PictureFormat::png;
  double frames_per_second = 30;
  bool json_output = false;
  bool verbose = false;
  bool quiet = false;

  void add_to(CLI::App& command);
  // Throws CLI::ValidationError for options that do not go together.
  void check() const;
  [[nodiscard]] FrameOptions frame_options() const;
  [[nodiscard]] TourOptions tour_options() const;  // without `views`
  [[nodiscard]] nlohmann::json json() const;       // those in effect
  [[nodiscard]] std::string mode_name() const;
  [[nodiscard]] std::string format_name() const;

 private:
  void add_cameras_to(CLI::App& command);
  void add_mode_to(CLI::App& command);
  void add_files_to(CLI::App& command);
  [[nodiscard]] static SettingFlags<RenderSettings> render_settings();
  // Throws as BlendFlags::finish() does.
  [[nodiscard]] RenderSettings values() const;
  void check_cameras() const;
  [[nodiscard]] Background background_in_use() const;

  std::vector<const CLI::Option*> cameras_;  // of which one must be given
  CLI::Option* of_scene_ = nullptr;
  CLI::Option* frames_per_second_option_ = nullptr;
};

}  // namespace lumatlas
