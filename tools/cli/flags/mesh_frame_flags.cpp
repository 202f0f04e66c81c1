// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/flags/mesh_frame_flags.h"

#include <CLI/Option.hpp>
#include <algorithm>

#include "tools/cli/flags/option_rules.h"

namespace lumatlas {

void MeshFrameFlags::add_to(CLI::App& command, CLI::Option* of) {
  options = {
      command
          .add_option("--mesh-scale", scale,
                      "Length of one unit of the mesh in units of the poses: 0.001 for millimetres and metres")
          ->type_name("S")
          ->check(finite_positive()),
      command
          .add_option("--mesh-axes", axes, "The poses' x, y and z as axes of the mesh: x,-z,y for a mesh that is y up")
          ->type_name("X,Y,Z")
          ->check(parsed_by(parse_mesh_axes)),
      command.add_option("--mesh-shift", shift, "Added to the mesh after scale and axes, such as -500000,-4500000,0")
          ->type_name("X,Y,Z")
          ->check(parsed_by(parse_mesh_shift))};
  for (CLI::Option* option : options) {
    if (of != nullptr) option->needs(of);
  }
}

std::optional<MeshFrame> MeshFrameFlags::frame() const {
  const auto is_given = [](const CLI::Option* option) { return option->count() > 0; };
  if (std::none_of(options.begin(), options.end(), is_given)) return std::nullopt;
  return MeshFrame{parse_mesh_axes(axes), scale, parse_mesh_shift(shift)};
}

}  // namespace lumatlas
