// SPDX-License-Identifier: GPL-3.0-or-later
// Numbers, poses and lenses in JSON, for the readers of OpenSfM, OpenMVG and Meshroom.
//
// All functions throw InputError, one sentence with file and place, where a value is not what they are asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "tools/base/strict_json.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/fields/brown_lens.h"
#include "tools/scene/lenses/camera_model.h"

namespace lumatlas {

// A finite number, or a text that is one, such as "0.5": some programs write all numbers as texts.
[[nodiscard]] double number_in(const JsonPlace& place);
// Numbers as number_in() reads them, in an array of exactly `count`.
[[nodiscard]] std::vector<double> numbers_in(const JsonPlace& place, std::size_t count);
// A side of a photograph, pixels: a whole number in [1, 65536].
[[nodiscard]] std::uint32_t pixels_in(const JsonPlace& place);
// true, "true", 1 or "1"; false for false, "false", 0 and "0".
[[nodiscard]] bool flag_in(const JsonPlace& place);
// Returns true for an empty text, which some programs write in place of an empty list.
[[nodiscard]] bool is_empty_text(const JsonPlace& place);
// A whole number that is at least 0, or a text, as a text: 7 and "7" are the same id.
[[nodiscard]] std::string id_in(const JsonPlace& place);

// A change of coordinates: inner = rotation * (outer - center). `center` is in outer coordinates. For a camera's pose
// cam_from_world, `center` is where the camera stands.
struct RigidPose {
  glm::dmat3 rotation{1.0};
  glm::dvec3 center{0.0};
};
// a_from_c = a_from_b * b_from_c.
[[nodiscard]] RigidPose operator*(const RigidPose& a_from_b, const RigidPose& b_from_c);

// Sets the photograph's pose. The camera looks along +z with y down. `place` is where the pose stands.
void set_pose(PosedPhotograph& photograph, const RigidPose& cam_from_world, const JsonPlace& place);

// lens_of(brown) in brown_lens.h, but refuses at `place` where that throws.
[[nodiscard]] CameraModel lens_at(const JsonPlace& place, const BrownLens& brown);
// The lens of `model`, which has the parameters fx, fy, cx and cy, and `coefficients` after these. Size and the first
// four parameters are those of `pinhole`; its coefficients are not looked at.
[[nodiscard]] CameraModel lens_at(const JsonPlace& place, LensModel model, const BrownLens& pinhole,
                                  std::initializer_list<double> coefficients);
// A panorama of the whole sphere, COLMAP's EQUIRECTANGULAR: its middle shows +z of the camera frame, its right half +x,
// its lower half +y. Refused unless it is twice as wide as high.
[[nodiscard]] CameraModel panorama_at(const JsonPlace& place, std::uint32_t width, std::uint32_t height);

}  // namespace lumatlas
