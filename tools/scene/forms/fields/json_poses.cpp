// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/json_poses.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "mesh/base/number_text.h"
#include "mesh/base/text_fields.h"
#include "tools/scene/forms/fields/brown_lens.h"

namespace lumatlas {

double number_in(const JsonPlace& place) {
  if (!place.value().is_string()) return place.number();
  const std::string text = place.text();
  const std::optional<double> number = parse_number(text);
  if (!number || !std::isfinite(*number)) place.refuse("is " + in_quotes(text) + ", must be a finite number");
  return *number;
}

bool is_empty_text(const JsonPlace& place) {
  return place.value().is_string() && place.value().get_ref<const std::string&>().empty();
}

std::vector<double> numbers_in(const JsonPlace& place, std::size_t count) {
  const std::vector<JsonPlace> elements = place.elements();
  if (elements.size() != count) {
    place.refuse("has " + std::to_string(elements.size()) + " values, must have " + std::to_string(count));
  }
  std::vector<double> numbers;
  numbers.reserve(elements.size());
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
    place.refuse(std::string("has an impossible camera: ") + error.what());
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

}  // namespace lumatlas
