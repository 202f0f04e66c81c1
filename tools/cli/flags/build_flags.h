// SPDX-License-Identifier: GPL-3.0-or-later
// The options of `lumatlas build`.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <filesystem>
#include <string>

#include "tools/cli/commands.h"
#include "tools/cli/flags/georeference_flag.h"
#include "tools/cli/flags/image_flags.h"
#include "tools/cli/flags/mesh_frame_flags.h"
#include "tools/cli/flags/setting_flags.h"
#include "tools/pipeline/build_options.h"
#include "tools/viewer/http/site_server.h"

namespace lumatlas {

struct BuildFlags {
  std::filesystem::path scene, output, mesh;
  BuildOptions options;  // with what an option sets directly
  SettingFlags<BuildOptions> settings;
  PictureFlags pictures;
  HoldFlags hold;
  MeshFrameFlags mesh_frame;
  GeoreferenceFlag georeference;
  double loss_db = 0.1;
  std::string budget_size;  // empty: unbounded
  std::string faces;        // empty: none was given
  std::string texture = std::to_string(*BuildOptions{}.texture_px);
  bool skip_bad = false;
  bool paper = false;
  ImageFlags images;
  bool watch = false;
  std::uint32_t idle_s = 0;  // 0: it ends by Ctrl-C alone
  bool mesh_as_given = false;
  bool view = false;
  bool no_browser = false;
  ServerOptions server;
  bool json_output = false;
  bool quiet = false;
  bool verbose = false;
  CLI::Option* max_views = nullptr;
  CLI::Option* budget = nullptr;
  CLI::Option* loss = nullptr;
  CLI::Option* photograph_bytes = nullptr;
  CLI::Option* refine = nullptr;

  BuildFlags();
  void add_to(CLI::App& command);

 private:
  void add_files_to(CLI::App& command);
  void add_stream_to(CLI::App& command);
  void add_model_to(CLI::App& command);
  void add_messages_to(CLI::App& command);
  void add_rare_mesh_options_to(CLI::App& command);
  void add_rare_model_options_to(CLI::App& command);
  void add_rare_watch_options_to(CLI::App& command);
};

// Words that --budget, --faces and --texture take.
inline constexpr const char* kAuto = "auto";  // as little as a bound on the loss allows, as many faces as pictures show
inline constexpr const char* kKeep = "keep";
inline constexpr const char* kNoTexture = "none";

// Returns the options that all flags together ask for. Throws CLI::ValidationError for options and settings that do not
// go together.
[[nodiscard]] BuildOptions build_options_of(const BuildFlags& flags);

}  // namespace lumatlas
