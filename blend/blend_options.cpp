// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/blend_options.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require(bool holds, const char* field, double value, const char* rule) {
  if (!holds) {
    throw std::invalid_argument("blend: " + std::string(field) + " is " + number_text(value) + ", must be " + rule);
  }
}

}  // namespace

BlendOptions BlendOptions::printed() {
  BlendOptions options;
  options.position = Position::printed;
  options.rims = false;
  options.fade_last = false;
  options.consistent = false;
  options.frame_fade = 0;
  options.sampling = Sampling::linear;
  options.soften = false;
  options.soft_edges = false;
  options.outlines = false;
  options.prefilter = false;
  options.border_width = 0;
  options.exposure = Exposure::model;
  options.supersample = 1;
  options.occlusion_tolerance = 0;
  return options;
}

BlendOptions BlendOptions::draft() {
  BlendOptions options;
  options.sampling = Sampling::linear;
  options.soft_edges = false;
  options.outlines = false;
  options.border_width = 0;
  options.supersample = 1;
  return options;
}

void check(const BlendOptions& options) {
  require(options.views >= 1 && options.views <= kMaxBlendedViews, "views", options.views, "in [1, 8]");
  require(options.lambda >= 0 && options.lambda <= 1, "lambda", options.lambda, "in [0, 1]");
  // A cast or a language binding may have given an enumeration any number.
  require(options.position == BlendOptions::Position::ratio || options.position == BlendOptions::Position::printed,
          "position", static_cast<int>(options.position), "one of BlendOptions::Position");
  require(options.exposure == BlendOptions::Exposure::nearby || options.exposure == BlendOptions::Exposure::model,
          "exposure", static_cast<int>(options.exposure), "one of BlendOptions::Exposure");
  require(options.sampling == BlendOptions::Sampling::linear || options.sampling == BlendOptions::Sampling::cubic,
          "sampling", static_cast<int>(options.sampling), "one of BlendOptions::Sampling");
  require(
      options.antialias == BlendOptions::Antialias::silhouettes || options.antialias == BlendOptions::Antialias::all,
      "antialias", static_cast<int>(options.antialias), "one of BlendOptions::Antialias");
  require(options.border_width >= 0 && options.border_width <= 1, "border_width", options.border_width, "in [0, 1]");
  require(options.frame_fade >= 0 && options.frame_fade <= 0.5, "frame_fade", options.frame_fade, "in [0, 0.5]");
  require(options.supersample >= 1 && options.supersample <= kMostSupersampling, "supersample", options.supersample,
          "in [1, 4]");
  require(std::isfinite(options.occlusion_tolerance) && options.occlusion_tolerance >= 0, "occlusion_tolerance",
          options.occlusion_tolerance, "finite and not negative");
}

}  // namespace lumatlas
