// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/json_poses.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

double number_in(const JsonPlace& place) {
  if (!place.value().is_string()) return place.number();
  const std::string text = place.text();
  const std::optional<double> number = parse_number(text);
  if (!number || !std::isfinite(*number)) place.refuse("is " + in_quotes(text) + ", must be a finite number");
  return *number;
}

std::vector<double> numbers_in(const JsonPlace& place, std::size_t count) {
  const std::vector<JsonPlace> elements = place.elements();
  if (elements.size() != count) {
    place.refuse("has " + std::to_string(elements.size()) + " values, must have " + std::to_string(count));
  }
  std::vector<double> numbers;
  for (const JsonPlace& element : elements) numbers.push_back(number_in(element));
  return numbers;
}

std::uint32_t pixels_in(const JsonPlace& place) {
  const double value = number_in(place);
  if (!(value >= 1 && value <= 65536) || value != std::floor(value)) {
    place.refuse("is " + number_text(value) + ", must be a whole number in [1, 65536]");
  }
  return static_cast<std::uint32_t>(value);
}

bool flag_in(const JsonPlace& place) {
  if (place.value().is_boolean()) return place.boolean();
  if (place.value() == "true") return true;
  if (place.value() == "false") return false;
  const double value = number_in(place);
  if (value != 0 && value != 1) place.refuse("is " + number_text(value) + ", must be 0 or 1");
  return value == 1;
}

std::string id_in(const JsonPlace& place) {
  if (place.value().is_number_unsigned()) return std::to_string(place.value().get<std::size_t>());
  if (place.value().is_number()) place.refuse("is " + place.value().dump() + ", must be a whole number from 0 on");
  return place.text();
}

RigidPose operator*(const RigidPose& a_from_b, const RigidPose& b_from_c) {
  return {a_from_b.rotation * b_from_c.rotation, b_from_c.center + glm::transpose(b_from_c.rotation) * a_from_b.center};
}

void set_pose(PosedPhotograph& photograph, const RigidPose& cam_from_world, const JsonPlace& place) {
  const std::string broken = set_pose(photograph, glm::transpose(cam_from_world.rotation), cam_from_world.center,
                                      CameraAxes::right_down_forward);
  if (!broken.empty()) place.refuse(broken);
}

namespace {

template <typename Make>
CameraModel possible_lens(const JsonPlace& place, const Make& make) {
  try {
    return make();
  } catch (const std::invalid_argument& error) {
    place.refuse(std::string("has a camera that cannot be: ") + error.what());
  }
}

}  // namespace

CameraModel lens_at(const JsonPlace& place, const BrownLens& brown) {
  return possible_lens(place, [&] { return lens_of(brown); });
}

CameraModel lens_at(const JsonPlace& place, LensModel model, const BrownLens& pinhole,
                    std::initializer_list<double> coefficients) {
  CameraModel lens{model, pinhole.width, pinhole.height, {pinhole.fx, pinhole.fy, pinhole.cx, pinhole.cy}};
  std::copy(coefficients.begin(), coefficients.end(), lens.parameters.begin() + 4);
  return possible_lens(place, [&] {
    check(lens);
    return lens;
  });
}

CameraModel panorama_at(const JsonPlace& place, std::uint32_t width, std::uint32_t height) {
  if (width != 2 * height) {
    place.refuse("is a panorama of " + size_text(width, height) +
                 " pixels, must be twice as wide as high: pad it to the whole sphere");
  }
  return {LensModel::kEquirectangular, width, height, {static_cast<double>(width), static_cast<double>(height)}};
}

namespace {

bool is_among(std::string_view key, std::span<const std::string_view> keys) {
  return std::find(keys.begin(), keys.end(), key) != keys.end();
}

// Whether a value is a number other than 0 or holds one, at any depth that parse_json() lets through.
bool holds_a_number(const nlohmann::json& value) {
  if (value.is_number()) return value.get<double>() != 0;
  if (value.is_string()) return parse_number(value.get_ref<const std::string&>()).value_or(0) != 0;
  return value.is_structured() && std::any_of(value.begin(), value.end(), holds_a_number);
}

}  // namespace

void UnknownKeys::look_at(const JsonPlace& object, std::span<const std::string_view> known) {
  if (!object.value().is_object()) object.refuse("must be an object");
  for (const auto& [key, value] : object.value().items()) {
    if (!is_among(key, known)) keys_.insert(key);
  }
}

void UnknownKeys::look_at_lens(const JsonPlace& lens, std::span<const std::string_view> known) {
  look_at(lens, known);
  for (const auto& [key, value] : lens.value().items()) {
    if (is_among(key, known) || !holds_a_number(value)) continue;
    lens.at(key).refuse(
        "is not read of a lens of this kind, and may bend the picture: undistort the photographs first");
  }
}

void UnknownKeys::tell(const std::filesystem::path& path, Capture& posed) const {
  if (keys_.empty()) return;
  constexpr std::size_t kMostNamed = 10;
  std::string names;
  std::size_t named = 0;
  for (const std::string& key : keys_) {
    if (++named > kMostNamed) break;
    names += (names.empty() ? "" : ", ") + short_reason(key);
  }
  const std::string more =
      keys_.size() > kMostNamed ? ", and " + std::to_string(keys_.size() - kMostNamed) + " more" : "";
  posed.notes.push_back(path.filename().string() + " has keys that are not known and not used: " + names + more);
}

}  // namespace lumatlas
