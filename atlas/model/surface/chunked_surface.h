// SPDX-License-Identifier: GPL-3.0-or-later
// Some chunks of a model's surface, without its views: what a program needs that works on one part of a large scene.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "atlas/surface.h"

namespace lumatlas {

// Counts of what one chunk has, without guests and the far sphere.
struct ChunkCounts {
  std::size_t cells = 0, faces = 0;
};

// Chunks one after the other: the cells and faces of each follow those of the one before. Cells and chunks share the
// vertices where they meet, which a file has once for each cell.
struct ChunkedSurface {
  Surface surface;  // without the far sphere
  FarSphere far;    // empty unless the chunk that holds it is among them
  std::vector<ChunkCounts> chunks;
};

// Returns the files of the chunks of a model's folder, or of its tileset.json, in their order. Throws InputError.
[[nodiscard]] std::vector<std::filesystem::path> chunk_files(const std::filesystem::path& model);

// Reads these chunks, of one model or of several that have the same offset and cell size, and no other file. Throws
// InputError naming the first file that breaks a rule, std::invalid_argument for no chunk at all.
[[nodiscard]] ChunkedSurface read_chunks(std::span<const std::filesystem::path> files);

}  // namespace lumatlas
