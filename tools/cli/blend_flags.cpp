// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/blend_flags.h"

#include <nlohmann/json.hpp>

#include "tools/cli/commands.h"
#include "tools/cli/option_rules.h"

namespace lumatlas {

namespace {

const Names<BlendOptions::Sampling> kSamplings{{"linear", BlendOptions::Sampling::linear},
                                               {"cubic", BlendOptions::Sampling::cubic}};
const Names<BlendOptions::Exposure> kExposures{{"nearby", BlendOptions::Exposure::nearby},
                                               {"model", BlendOptions::Exposure::model}};
const Names<BlendOptions::Antialias> kAntialiases{{"silhouettes", BlendOptions::Antialias::silhouettes},
                                                  {"all", BlendOptions::Antialias::all}};
const Names<bool> kWeights{{"ratio", false}, {"printed", true}};
const Names<bool> kSwitch{{"off", false}, {"on", true}};

// Our default, and the paper's.
template <typename Value>
std::string defaults(const Value& ours, const Value& printed) {
  return CLI::detail::to_string(ours) + ", printed " + CLI::detail::to_string(printed);
}

template <typename Value>
std::string defaults(const Names<Value>& names, Value ours, Value printed) {
  return defaults(name_of(names, ours), name_of(names, printed));
}

void depart(BlendOptions& options, const std::string& departure) {
  const BlendOptions ours;
  if (departure == "position") options.position = ours.position;
  if (departure == "rims") options.rims = ours.rims;
  if (departure == "fade-last") options.fade_last = ours.fade_last;
  if (departure == "consistent") options.consistent = ours.consistent;
  if (departure == "frame") options.frame_fade = ours.frame_fade;
  if (departure == "border") options.border_width = ours.border_width;
  if (departure == "soften") options.soften = ours.soften;
  if (departure == "sampling") options.sampling = ours.sampling;
  if (departure == "occlusion") options.occlusion_tolerance = ours.occlusion_tolerance;
}

}  // namespace

void BlendFlags::add_to(CLI::App& command) {
  const BlendOptions ours, printed = BlendOptions::printed();
  CLI::Option* const paper =
      command.add_flag("--paper", paper_, "Blend as the paper prints it, for models of `build --paper`");
  command.add_flag("--draft", draft_, "Draw faster, with coarser sampling and edges")->excludes(paper);
  exposure_option_ = add_choice(command, "--exposure", exposure_, kExposures,
                                "Expose as the photographs taken nearby, or one exposure for the model",
                                defaults(kExposures, ours.exposure, printed.exposure));
  supersample_option_ = command.add_option("--supersample", supersample_, "Pixels at silhouettes are means of N x N")
                            ->type_name("N")
                            ->transform(whole_number(1, kMostSupersampling))
                            ->default_str(defaults(ours.supersample, printed.supersample));
}

void BlendFlags::add_experiments_to(CLI::App& command) {
  const BlendOptions ours, printed = BlendOptions::printed();
  begin_experiments(command, "blending");
  command.add_option("--blend-views", values_.views, "How many views are blended at a pixel: the paper's K")
      ->type_name("N")
      ->transform(whole_number(1, kMaxBlendedViews));
  command
      .add_option("--blend-direction-weight", values_.lambda,
                  "Weight of direction against distance when views are blended")
      ->type_name("W")
      ->check(number_between(0, 1));
  weights_option_ =
      add_choice(command, "--weights", printed_weights_, kWeights,
                 "How a view's distance counts; printed takes the paper's formulas for everything in this group");
  departures_option_ = command
                           .add_option("--blend-depart", departures_,
                                       "With --weights printed, depart from it in these alone, separated by commas")
                           ->type_name("NAMES")
                           ->check(one_of({"position", "rims", "fade-last", "consistent", "frame", "border",
                                           "occlusion", "soften", "sampling"}))
                           ->delimiter(',')
                           ->default_str("");
  sampling_option_ =
      add_choice(command, "--sampling", sampling_, kSamplings, "Between a photograph's pixels; cubic is sharper",
                 defaults(kSamplings, ours.sampling, printed.sampling));
  prefilter_option_ = add_choice(command, "--prefilter", prefilter_, kSwitch,
                                 "Sample photographs that were taken from nearer at their coarser levels",
                                 defaults(kSwitch, ours.prefilter, printed.prefilter));
  soften_option_ = add_choice(command, "--soften", soften_, kSwitch,
                              "Blur photographs seen from beside where the surface is uncertain",
                              defaults(kSwitch, ours.soften, printed.soften));
  consistency_option_ = add_choice(command, "--consistency", consistent_, kSwitch,
                                   "Show a photograph alone in a picture from where it was taken",
                                   defaults(kSwitch, ours.consistent, printed.consistent));
  const auto add_share = [&](const char* name, std::optional<double>& share, double most,
                             const std::string& unless_given, const char* help) {
    return command.add_option(name, share, help)
        ->type_name("SHARE")
        ->check(number_between(0, most))
        ->default_str(unless_given);
  };
  frame_fade_option_ =
      add_share("--frame-fade", frame_fade_, 0.5, defaults(ours.frame_fade, printed.frame_fade),
                "Over which a view fades out at its photograph's border, as a share of the shorter side");
  border_width_option_ =
      add_share("--border-width", border_width_, 1, defaults(ours.border_width, printed.border_width),
                "Over which neighbouring cells fade into each other, as a share of the cell size");
  add_choice(command, "--antialias", values_.antialias, kAntialiases,
             "Which pixels --supersample is about; all takes N x N + 1 times as long");
}

void BlendFlags::check_paper() const {
  const BlendOptions printed = BlendOptions::printed();
  agree_with_paper(*weights_option_, printed_weights_, "printed");
  agree_with_paper(*departures_option_, departures_.empty(), "without departures");
  agree_with_paper(*sampling_option_, sampling_ == printed.sampling, name_of(kSamplings, printed.sampling));
  agree_with_paper(*exposure_option_, exposure_ == printed.exposure, name_of(kExposures, printed.exposure));
  agree_with_paper(*soften_option_, soften_ == printed.soften, name_of(kSwitch, printed.soften));
  agree_with_paper(*prefilter_option_, prefilter_ == printed.prefilter, name_of(kSwitch, printed.prefilter));
  agree_with_paper(*consistency_option_, consistent_ == printed.consistent, name_of(kSwitch, printed.consistent));
  agree_with_paper(*frame_fade_option_, frame_fade_ == printed.frame_fade, CLI::detail::to_string(printed.frame_fade));
  agree_with_paper(*border_width_option_, border_width_ == printed.border_width,
                   CLI::detail::to_string(printed.border_width));
  agree_with_paper(*supersample_option_, supersample_ == printed.supersample,
                   CLI::detail::to_string(printed.supersample));
}

BlendOptions BlendFlags::options() const {
  if (paper_) check_paper();
  BlendOptions options = paper_ || printed_weights_ ? BlendOptions::printed()
                         : draft_                   ? BlendOptions::draft()
                                                    : BlendOptions{};
  options.views = values_.views;
  options.lambda = values_.lambda;
  options.antialias = values_.antialias;
  for (const std::string& departure : departures_) depart(options, departure);
  options.supersample = supersample_.value_or(options.supersample);
  options.soften = soften_.value_or(options.soften);
  options.prefilter = prefilter_.value_or(options.prefilter);
  options.consistent = consistent_.value_or(options.consistent);
  options.frame_fade = frame_fade_.value_or(options.frame_fade);
  options.border_width = border_width_.value_or(options.border_width);
  options.sampling = sampling_.value_or(options.sampling);
  options.exposure = exposure_.value_or(options.exposure);
  check(options);
  return options;
}

nlohmann::json BlendFlags::json() const {
  const BlendOptions effective = options();
  return {{"blend_views", effective.views},
          {"blend_direction_weight", effective.lambda},
          {"weights", name_of(kWeights, paper_ || printed_weights_)},
          {"draft", draft_},
          {"soften", effective.soften},
          {"prefilter", effective.prefilter},
          {"consistency", effective.consistent},
          {"sampling", name_of(kSamplings, effective.sampling)},
          {"blend_depart", departures_},
          {"frame_fade", effective.frame_fade},
          {"border_width", effective.border_width},
          {"supersample", effective.supersample},
          {"antialias", name_of(kAntialiases, effective.antialias)},
          {"exposure", name_of(kExposures, effective.exposure)}};
}

}  // namespace lumatlas
