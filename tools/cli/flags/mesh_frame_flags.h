// SPDX-License-Identifier: GPL-3.0-or-later
// The options for a mesh file in another frame than the poses, for every command that reads one.
#pragma once

#include <CLI/App.hpp>
#include <array>
#include <optional>
#include <string>

#include "tools/scene/mesh/mesh_frame.h"

namespace lumatlas {

struct MeshFrameFlags {
  double scale = 1;
  std::string axes = "x,y,z", shift = "0,0,0";
  std::array<CLI::Option*, 3> options{};

  // `of`: the option that names the mesh file, if these mean nothing without it.
  void add_to(CLI::App& command, CLI::Option* of = nullptr);
  // Returns the frame if at least one of the options was given.
  [[nodiscard]] std::optional<MeshFrame> frame() const;
};

}  // namespace lumatlas
