// SPDX-License-Identifier: GPL-3.0-or-later
// The options of blending, for every command that renders.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "blend/blend_options.h"

namespace lumatlas {

class BlendFlags {
 public:
  // --paper, --draft, --exposure and --supersample.
  void add_to(CLI::App& command);
  // All others.
  void add_experiments_to(CLI::App& command);

  // Throws CLI::ValidationError for an option that says otherwise than --paper, std::invalid_argument as check() does.
  [[nodiscard]] BlendOptions options() const;
  [[nodiscard]] nlohmann::json json() const;  // those in effect

 private:
  void check_paper() const;

  BlendOptions values_;
  bool paper_ = false;
  bool draft_ = false;
  bool printed_weights_ = false;
  // None: as the weights have them.
  std::optional<BlendOptions::Sampling> sampling_;
  std::optional<BlendOptions::Exposure> exposure_;
  std::optional<bool> soften_;
  std::optional<bool> prefilter_;
  std::optional<bool> consistent_;
  std::optional<double> frame_fade_;
  std::optional<double> border_width_;
  std::optional<std::uint32_t> supersample_;
  std::vector<std::string> departures_;
  CLI::Option* weights_option_ = nullptr;
  CLI::Option* departures_option_ = nullptr;
  CLI::Option* sampling_option_ = nullptr;
  CLI::Option* exposure_option_ = nullptr;
  CLI::Option* soften_option_ = nullptr;
  CLI::Option* prefilter_option_ = nullptr;
  CLI::Option* consistency_option_ = nullptr;
  CLI::Option* frame_fade_option_ = nullptr;
  CLI::Option* border_width_option_ = nullptr;
  CLI::Option* supersample_option_ = nullptr;
};

}  // namespace lumatlas
