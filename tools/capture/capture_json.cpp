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

nlohmann::json videos_json(const std::vector<CapturedVideo>& videos) {
  nlohmann::json list = nlohmann::json::array();
  for (const CapturedVideo& video : videos) {
    list.push_back({{"name", video.name},
                    {"frames", video.frames},
                    {"taken", video.taken},
                    {"seconds", video.seconds},
                    {"damage", video.damage.empty() ? nlohmann::json() : nlohmann::json(video.damage)}});
  }
  return list;
}

}  // namespace

nlohmann::json capture_json(const CaptureResult& result, const std::filesystem::path& work,
                            const std::filesystem::path& model) {
  return {{"output", model.string()},
          {"scene", work.string()},
          {"photographs",
           {{"count", result.photographs},
            {"converted", result.converted},
            {"missed", result.missed},
            {"outliers", result.outliers}}},
          {"videos", videos_json(result.videos)},
          {"left_out", result.left_out},
          {"reconstructions", result.reconstructions},
          {"steps", steps_json(result)},
          {"warnings", result.warnings}};
}

}  // namespace lumatlas
