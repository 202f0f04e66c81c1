// SPDX-License-Identifier: GPL-3.0-or-later
// The subcommands of the program. Each adds itself with its options; its callback does the work and throws.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>

#include "tools/cli/flags/option_rules.h"
#include "tools/cli/output/help_formatter.h"
#include "tools/scene/scene.h"

namespace lumatlas {

void add_inspect_command(CLI::App& program);
void add_capture_command(CLI::App& program);
void add_mesh_command(CLI::App& program);
void add_build_command(CLI::App& program);
void add_city_command(CLI::App& program);
void add_live_command(CLI::App& program);
void add_render_command(CLI::App& program);
void add_validate_command(CLI::App& program);
void add_export_command(CLI::App& program);
void add_view_command(CLI::App& program);
void add_synth_command(CLI::App& program);
void add_chart_command(CLI::App& program);

// Options that break a rule which the parser cannot know are wrong usage too.
template <typename Options>
void check_usage(const Options& options) {
  try {
    check(options);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(error.what());
  }
}

// An option that names a file or folder.
inline CLI::Option* add_file(CLI::App& command, const std::string& option, std::filesystem::path& path,
                             const std::string& value_name, const std::string& description) {
  return command.add_option(option, path, description)->type_name(value_name)->check(file_name())->default_str("");
}

// -o of the commands that make a model.
inline void add_model_output(CLI::App& command, std::filesystem::path& model) {
  add_file(command, "-o,--output", model, "MODEL",
           "Folder, or one file that ends in .glb; an earlier model there is replaced")
      ->required()
      ->check(model_name());
}

// --quiet and --json mean the same in every command.
inline void add_json(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print the results as JSON");
}
inline void add_quiet(CLI::App& command, bool& quiet) {
  command.add_flag("--quiet", quiet, "Print no progress and no advice");
}

inline void add_images(CLI::App& command, std::filesystem::path& images) {
  add_file(command, "--images", images, "DIR", "Folder of the photographs, if not SCENE/images");
}

// --images and --masks of several commands.
struct PictureFlags {
  std::filesystem::path images, masks;

  void add_to(CLI::App& command) {
    add_images(command, images);
    add_file(command, "--masks", masks, "DIR", "Folder of masks, if not SCENE/masks; what is black is not used");
  }
  [[nodiscard]] PictureFolders folders() const {
    PictureFolders result;
    if (!images.empty()) result.images = images;
    if (!masks.empty()) result.masks = masks;
    return result;
  }
};

// --hold and --block of several commands.
struct HoldFlags {
  std::size_t hold = 8;
  std::size_t block = 1;
  CLI::Option* hold_option = nullptr;

  void add_to(CLI::App& command, const char* what) {
    hold_option =
        command.add_option("--hold", hold, what)->type_name("H")->transform(whole_number(2, kMost))->default_str("");
    command.add_option("--block", block, "With --hold, runs of this many neighbours instead of single ones")
        ->type_name("N")
        ->transform(whole_number(1, kMost))
        ->needs(hold_option);
  }
  [[nodiscard]] std::optional<HoldOut> protocol() const {
    if (hold_option->count() == 0) return std::nullopt;
    return HoldOut{hold, block};
  }

 private:
  static constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
};

// Throws CLI::ValidationError if the user gave the option beside --paper, which sets it to `value`, unless both agree.
inline void agree_with_paper(const CLI::Option& option, bool agrees, const std::string& value) {
  if (option.count() == 0 || agrees) return;
  throw CLI::ValidationError(option.get_name(), "is " + value + " by --paper: leave out one of the two");
}

}  // namespace lumatlas
