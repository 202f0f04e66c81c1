// SPDX-License-Identifier: GPL-3.0-or-later
// --image and --quality, for the commands that make a model.
#pragma once

#include <CLI/App.hpp>

#include "atlas/images/photograph.h"
#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"

namespace lumatlas {

class ImageFlags {
 public:
  void add_to(CLI::App& command) {
    add_choice(command, "--image", coding_.format, {{"png", ImageFormat::png}, {"jpeg", ImageFormat::jpeg}},
               "How photographs are kept in the model")
        ->transform(other_name("jpg", "jpeg"));
    quality_ = command.add_option("--quality", coding_.quality, "Quality of the JPEG files, with --image jpeg")
                   ->type_name("Q")
                   ->transform(whole_number(1, 100));
  }
  // Throws CLI::ValidationError for a quality that the format does not have.
  [[nodiscard]] ImageCoding coding() const {
    if (quality_->count() > 0 && coding_.format == ImageFormat::png) {
      throw CLI::ValidationError("--quality", "needs --image jpeg: PNG is exact");
    }
    return coding_;
  }

 private:
  ImageCoding coding_;
  CLI::Option* quality_ = nullptr;
};

}  // namespace lumatlas
