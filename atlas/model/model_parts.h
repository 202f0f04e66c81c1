// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: a snapshot as it is written, checked, with its images and the properties of the whole model.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "atlas/model/model_form.h"
#include "atlas/model/model_images.h"

namespace lumatlas {

struct ModelParts {
  Snapshot snapshot;               // without views that have no resident tile; of one in pieces without surface
  std::vector<ModelImage> images;  // in the file's order
  nlohmann::json properties;       // the whole model's, with its views, whose images are numbers in `images`
  glm::dvec3 offset{0.0};          // of the surface
  double cell_size = 0;            // as files have it
  float before_far = 0;            // depth_before_far() of the surface
};

// Throws what write_form() throws.
[[nodiscard]] ModelParts model_parts(const Snapshot& given, const ValidityOptions& validity,
                                     const FormOptions& options);
[[nodiscard]] ModelParts model_parts(const PiecewiseModel& given, const ValidityOptions& validity,
                                     const FormOptions& options);

// Returns the width of the grid of a packed surface's positions: a 16th of what a pixel of a stored photograph covers
// at its view's median depth, the least over the views, but no more than a hundredth of a cell. None unless packed.
[[nodiscard]] std::optional<double> packed_step(const ModelParts& model, const FormOptions& options);

}  // namespace lumatlas
