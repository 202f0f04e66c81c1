// SPDX-License-Identifier: GPL-3.0-or-later
// The options of blending, for every command that renders.
#pragma once

#include <CLI/App.hpp>
#include <CLI/Validators.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "blend/blend_options.h"
#include "tools/cli/number_flags.h"

namespace lumatlas {

struct BlendFlags {
  BlendOptions values;
  std::string weights = "ratio";
  std::string prefilter;  // empty: as the weights have it
  std::string sampling;   // empty: as the weights have it
  std::string exposure;   // empty: as the weights have it
  std::string antialias = "silhouettes";
  std::vector<std::string> departures;
  std::optional<double> border_width;
  std::optional<std::uint32_t> supersample;

  void add_to(CLI::App& command) {
    command.add_option("--blend-views", values.views, "K: how many views are blended at a pixel")
        ->check(CLI::Range(1u, kMaxBlendedViews));
    command.add_option("--lambda", values.lambda, "Weight of direction against distance when views are blended")
        ->check(number_between(0, 1));
    command.add_option("--weights", weights, "Distance term: ratio, or printed (the paper's formulas to the letter)")
        ->check(CLI::IsMember({"ratio", "printed"}));
    command
        .add_option("--prefilter", prefilter,
                    "Sample photographs that were taken from nearer at their coarser levels: on or off; without it on, "
                    "with --weights printed off")
        ->check(CLI::IsMember({"on", "off"}));
    command
        .add_option("--sampling", sampling,
                    "Between a photograph's pixels: linear or cubic, which is sharper; without it cubic, with "
                    "--weights printed linear")
        ->check(CLI::IsMember({"linear", "cubic"}));
    command
        .add_option("--blend-depart", departures,
                    "With --weights printed, single departures from it: position, rims, fade-last, border, occlusion, "
                    "sampling")
        ->check(CLI::IsMember({"position", "rims", "fade-last", "border", "occlusion", "sampling"}))
        ->delimiter(',');
    command
        .add_option("--border-width", border_width,
                    "Over which neighbouring cells fade into each other, as a share of the cell size; 0: not at all; "
                    "without it " +
                        CLI::detail::to_string(BlendOptions{}.border_width) + ", with --weights printed 0")
        ->check(number_between(0, 1));
    command
        .add_option(
            "--supersample", supersample,
            "N: where --antialias says, a pixel's colour is the mean of N x N samples in linear light; 1: nowhere; "
            "without it " +
                CLI::detail::to_string(BlendOptions{}.supersample) + ", with --weights printed 1")
        ->check(CLI::Range(1u, kMostSupersampling));
    command
        .add_option("--antialias", antialias,
                    "Which pixels are means of samples: silhouettes (those where one surface ends before another) or "
                    "all, which takes N * N + 1 times as long")
        ->check(CLI::IsMember({"silhouettes", "all"}));
    command
        .add_option(
            "--exposure", exposure,
            "Of the pictures: nearby (of the photographs taken nearby) or model (one for all); without it nearby, "
            "with --weights printed model")
        ->check(CLI::IsMember({"nearby", "model"}));
  }

  [[nodiscard]] BlendOptions options() const {
    BlendOptions options = weights == "printed" ? BlendOptions::printed() : BlendOptions{};
    options.views = values.views;
    options.lambda = values.lambda;
    if (supersample) options.supersample = *supersample;
    if (antialias == "all") options.antialias = BlendOptions::Antialias::all;
    if (!prefilter.empty()) options.prefilter = prefilter == "on";
    for (const std::string& departure : departures) depart(options, departure);
    if (border_width) options.border_width = *border_width;
    if (sampling == "linear") options.sampling = BlendOptions::Sampling::linear;
    if (sampling == "cubic") options.sampling = BlendOptions::Sampling::cubic;
    if (exposure == "nearby") options.exposure = BlendOptions::Exposure::nearby;
    if (exposure == "model") options.exposure = BlendOptions::Exposure::model;
    check(options);
    return options;
  }

  [[nodiscard]] nlohmann::json json() const {
    const bool nearby = options().exposure == BlendOptions::Exposure::nearby;
    return {{"blend_views", values.views},
            {"lambda", values.lambda},
            {"weights", weights},
            {"prefilter", options().prefilter},
            {"sampling", options().sampling == BlendOptions::Sampling::cubic ? "cubic" : "linear"},
            {"blend_depart", departures},
            {"border_width", options().border_width},
            {"supersample", options().supersample},
            {"antialias", antialias},
            {"exposure", nearby ? "nearby" : "model"}};
  }

 private:
  static void depart(BlendOptions& options, const std::string& departure) {
    const BlendOptions ours;
    if (departure == "position") options.position = ours.position;
    if (departure == "rims") options.rims = ours.rims;
    if (departure == "fade-last") options.fade_last = ours.fade_last;
    if (departure == "border") options.border_width = ours.border_width;
    if (departure == "sampling") options.sampling = ours.sampling;
    if (departure == "occlusion") options.occlusion_tolerance = ours.occlusion_tolerance;
  }
};

}  // namespace lumatlas
