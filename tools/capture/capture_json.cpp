// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/capture_json.h"

#include <nlohmann/json.hpp>

namespace lumatlas {

namespace {

nlohmann::json steps_json(const CaptureResult& result) {
  nlohmann::json steps = nlohmann::json::array();
  for (const CaptureStep& step : result.steps) {
    steps.push_back({{"name", step.name}, {"done_before", step.done_before}, {"ms", step.time_ms}});
  }
  return steps;
}

}  // namespace

nlohmann::json capture_json(const CaptureResult& result, const std::filesystem::path& work,
                            const std::filesystem::path& model) {
  return {{"output", model.string()},
          {"scene", work.string()},
          {"photographs", {{"count", result.photographs}, {"missed", result.missed}, {"outliers", result.outliers}}},
          {"reconstructions", result.reconstructions},
          {"steps", steps_json(result)},
          {"warnings", result.warnings}};
}

}  // namespace lumatlas
