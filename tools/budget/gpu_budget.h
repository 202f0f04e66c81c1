// SPDX-License-Identifier: GPL-3.0-or-later
// A bound on all that a model takes on the GPU: mesh, tables and photographs together.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "atlas/atlas.h"
#include "blend/gpu_bytes.h"

namespace lumatlas {

class GpuBudget {
 public:
  // Throws InputError, naming the mesh's file and both numbers, if the surface leaves no room for a tile of the layout,
  // which must cut views into tiles.
  GpuBudget(std::uint64_t bytes, const std::shared_ptr<const Surface>& surface, const TileOptions& layout,
            const std::filesystem::path& mesh_file);

  // Returns the bytes that the surface leaves for photographs, and for the tables that grow with them.
  [[nodiscard]] std::uint64_t bytes_left() const { return bytes_ - of_surface_; }

  // Returns the share of the tiles that the store's references need that fits: the bytes that mesh and tables leave, at
  // least one tile's, divided by those of these tiles. At >= 1 all fit, to within a few bytes. Lifts the store's bound
  // on tiles.
  [[nodiscard]] double fitting_share(Atlas& atlas) const;

  // Bounds the store's tiles, so that its snapshot takes no more than the budget, counted as GpuByteCount does, and as
  // many tiles as fit. Which cells can be joined, and so what the mesh takes, depends on the tiles that are chosen;
  // hence a few are tried. Throws InputError as above if not even one tile fits.
  [[nodiscard]] Snapshot fitted_snapshot(Atlas& atlas) const;

 private:
  [[noreturn]] void refuse(std::uint64_t least) const;

  std::uint64_t bytes_, of_surface_;
  std::filesystem::path mesh_file_;
  GpuByteCount count_;
};

// {"mesh", "vertices", "tables", "depth", "masks", "colors", "sum"}, bytes.
[[nodiscard]] nlohmann::json gpu_bytes_json(const GpuBytes& bytes);

// "38.1 MB: mesh 12.1, ..." of that.
[[nodiscard]] std::string gpu_bytes_text(const nlohmann::json& bytes);

}  // namespace lumatlas
