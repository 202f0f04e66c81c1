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
  options.sampling = Sampling::linear;
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
  options.border_width = 0;
  options.supersample = 1;
  return options;
}

void check(const BlendOptions& options) {
  require(options.views >= 1 && options.views <= kMaxBlendedViews, "views", options.views, "in [1, 8]");
  require(options.lambda >= 0 && options.lambda <= 1, "lambda", options.lambda, "in [0, 1]");
  require(options.border_width >= 0 && options.border_width <= 1, "border_width", options.border_width, "in [0, 1]");
  require(options.supersample >= 1 && options.supersample <= kMostSupersampling, "supersample", options.supersample,
          "in [1, 4]");
  require(std::isfinite(options.occlusion_tolerance) && options.occlusion_tolerance >= 0, "occlusion_tolerance",
          options.occlusion_tolerance, "finite and not negative");
}

}  // namespace lumatlas
