// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/blend_flags.h"

#include <nlohmann/json.hpp>
#include <string>

#include "tools/cli/commands.h"
#include "tools/cli/flags/option_rules.h"

namespace lumatlas {

namespace {

const Names<BlendOptions::Exposure> kExposures{{"nearby", BlendOptions::Exposure::nearby},
                                               {"model", BlendOptions::Exposure::model}};

// Our default, and the paper's.
std::string defaults(const std::string& ours, const std::string& printed) {
  return ours + ", with --paper " + printed;
}

}  // namespace

void BlendFlags::add_to(CLI::App& command) {
  const BlendOptions ours, printed = BlendOptions::printed();
  CLI::Option* const paper =
      command.add_flag("--paper", paper_, "Blend by the formulas of the paper, for models of `build --paper`");
  command.add_flag("--draft", draft_, "Draw faster, with coarser sampling and edges")->excludes(paper);
  exposure_option_ = add_choice(command, "--exposure", exposure_, kExposures,
                                "Use the exposure of the photographs taken nearby, or one exposure for the whole model",
                                defaults(name_of(kExposures, ours.exposure), name_of(kExposures, printed.exposure)));
  supersample_option_ =
      command.add_option("--supersample", supersample_, "Silhouettes as means of N x N samples")
          ->type_name("N")
          ->transform(whole_number(1, kMostSupersampling))
          ->default_str(defaults(std::to_string(ours.supersample), std::to_string(printed.supersample)));
}

void BlendFlags::agree_with_printed() const {
  const BlendOptions printed = BlendOptions::printed();
  agree_with_paper(*exposure_option_, exposure_ == printed.exposure, name_of(kExposures, printed.exposure));
  agree_with_paper(*supersample_option_, supersample_ == printed.supersample, std::to_string(printed.supersample));
}

BlendOptions BlendFlags::start() const {
  if (paper_) return BlendOptions::printed();
  return draft_ ? BlendOptions::draft() : BlendOptions();
}

void BlendFlags::finish(BlendOptions& options) const {
  if (paper_) agree_with_printed();
  options.exposure = exposure_.value_or(options.exposure);
  options.supersample = supersample_.value_or(options.supersample);
  check(options);
}

nlohmann::json BlendFlags::json(const BlendOptions& effective) const {
  return {
      {"draft", draft_}, {"exposure", name_of(kExposures, effective.exposure)}, {"supersample", effective.supersample}};
}

}  // namespace lumatlas
