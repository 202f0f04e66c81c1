// SPDX-License-Identifier: GPL-3.0-or-later
// Nodes and cameras that make a glTF file stand upright in other programs, and offer the photographs' viewpoints there.
#pragma once

#include <glm/mat3x3.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "atlas/snapshot.h"

namespace lumatlas {

// A file system's names are bytes, JSON's are Unicode: bytes that are not UTF-8 become U+FFFD, control characters '?'.
[[nodiscard]] std::string unicode_name(std::string name);

// Returns the rotation from the scene's frame to glTF's, +y upwards, which upright() and upward() of mesh/upright.h
// find by the stored views; the identity without views.
[[nodiscard]] glm::dmat3 gltf_from_scene(const Snapshot& snapshot);

// A node's "rotation".
[[nodiscard]] nlohmann::json gltf_rotation(const glm::dmat3& rotation);

// Adds, below the document's node 0, the root of its only scene, a node with a perspective
// camera for each stored view, in their order, both with the view's name. glTF's cameras have their principal point in
// the middle. If the view's is elsewhere, its glTF camera has a picture of the same shape, enlarged until it holds all
// of the view. What the view's own is stands in the camera's extras, pixels: imageSize, focalLength and principalPoint,
// from the top left corner.
void add_cameras(nlohmann::json& document, const Snapshot& snapshot);

}  // namespace lumatlas
