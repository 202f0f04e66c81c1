// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/score/report/json_fields.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace lumatlas {

namespace {

template <typename AnyScores>
nlohmann::json common_scores(const AnyScores& scores) {
  nlohmann::json json = {{"raw", json_scores(scores.raw)},
                         {"fitted", json_scores(scores.fitted)},
                         {"textured", json_number(scores.textured)}};
  if (scores.aligned) {
    json["aligned"] = json_scores(*scores.aligned);
  }
  return json;
}

nlohmann::json json_region(const RegionScores& scores) {
  nlohmann::json json = common_scores(scores);
  json["gain"] = json_number(scores.gain);
  json["pixels"] = scores.pixels;
  if (scores.aligned) json["aligned_pixels"] = scores.aligned_pixels;
  return json;
}

}  // namespace

nlohmann::json json_number(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}

nlohmann::json json_scores(const Scores& scores) {
  const double psnr = std::isnan(scores.psnr) ? scores.psnr : std::min(scores.psnr, kPsnrOfIdentical);
  return {{"psnr", json_number(psnr)}, {"ssim", json_number(scores.ssim)}};
}

nlohmann::json json_scores(const MethodScores& scores) {
  nlohmann::json json = common_scores(scores.mesh);
  json["frame"] = common_scores(scores.frame);
  return json;
}

nlohmann::json json_scores(const ViewScores& scores) {
  nlohmann::json json = json_region(scores.mesh);
  json["frame"] = json_region(scores.frame);
  return json;
}

}  // namespace lumatlas
