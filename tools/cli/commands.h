// SPDX-License-Identifier: GPL-3.0-or-later
// The subcommands of the program. Each adds itself with its options; its callback does the work and throws.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Error.hpp>
#include <CLI/Formatter.hpp>
#include <optional>
#include <stdexcept>

#include "tools/scene/scene.h"

namespace lumatlas {

void add_inspect_command(CLI::App& program);
void add_build_command(CLI::App& program);
void add_render_command(CLI::App& program);
void add_validate_command(CLI::App& program);
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

// --hold and --block of several commands.
struct HoldFlags {
  std::size_t hold = 8;
  std::size_t block = 1;
  CLI::Option* hold_option = nullptr;

  void add_to(CLI::App& command, const char* what) {
    hold_option = command.add_option("--hold", hold, what)->check(CLI::Range(std::size_t{2}, std::size_t{1} << 31));
    command.add_option("--block", block, "With --hold: leave out runs of this many neighbours")
        ->check(CLI::Range(std::size_t{1}, std::size_t{1} << 31))
        ->needs(hold_option);
  }
  [[nodiscard]] std::optional<HoldOut> protocol() const {
    if (hold_option->count() == 0) return std::nullopt;
    return HoldOut{hold, block};
  }
};

}  // namespace lumatlas
