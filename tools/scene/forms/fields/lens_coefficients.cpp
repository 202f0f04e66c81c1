// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/lens_coefficients.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace lumatlas {

namespace {

constexpr auto kCoefficients =
    std::to_array<std::string_view>({"k0",         "k1",    "k2",   "k3",    "k4",
                                     "k5",         "k6",    "p1",   "p2",    "p3",
                                     "p4",         "s1",    "s2",   "s3",    "s4",
                                     "b1",         "b2",    "skew", "omega", "alpha",
                                     "beta",       "xi",    "tauX", "tauY",  "distortion_params",
                                     "distortion", "params"});

bool is_zero(const nlohmann::json& value) {
  if (value.is_number()) return value.get<double>() == 0;
  if (value.is_array()) return std::all_of(value.begin(), value.end(), is_zero);
  return value.is_null();
}

}  // namespace

bool is_lens_coefficient(std::string_view key) {
  return std::find(kCoefficients.begin(), kCoefficients.end(), key) != kCoefficients.end();
}

void refuse_unread_coefficients(const std::function<std::optional<JsonPlace>(std::string_view key)>& find,
                                std::span<const std::string_view> read, const std::string& lens) {
  for (const std::string_view key : kCoefficients) {
    if (std::find(read.begin(), read.end(), key) != read.end()) continue;
    const std::optional<JsonPlace> place = find(key);
    if (!place || is_zero(place->value())) continue;
    place->refuse("is a coefficient that this program does not read" + lens + ": undistort the photographs first");
  }
}

}  // namespace lumatlas
