// SPDX-License-Identifier: GPL-3.0-or-later
// The options of blending, for every command that renders; blend_settings() has the rest.
#pragma once

#include <CLI/App.hpp>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "blend/blend_options.h"

namespace lumatlas {

// --paper, --draft, --exposure and --supersample.
class BlendFlags {
 public:
  void add_to(CLI::App& command);

  [[nodiscard]] bool paper() const { return paper_; }
  // Returns the options that settings start from.
  [[nodiscard]] BlendOptions start() const;
  // Adds what these options say to what settings have made of start(). Throws CLI::ValidationError for an option that
  // says otherwise than --paper, std::invalid_argument as check() does.
  void finish(BlendOptions& options) const;
  // Returns the options that are in effect.
  [[nodiscard]] nlohmann::json json(const BlendOptions& effective) const;

 private:
  void agree_with_printed() const;

  bool paper_ = false;
  bool draft_ = false;
  // Empty: the value that goes with the weights.
  std::optional<BlendOptions::Exposure> exposure_;
  std::optional<std::uint32_t> supersample_;
  CLI::Option* exposure_option_ = nullptr;
  CLI::Option* supersample_option_ = nullptr;
};

}  // namespace lumatlas
