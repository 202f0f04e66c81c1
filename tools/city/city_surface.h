// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/city/: the surface of a city as its plan keeps it, in pieces one after the other. Each piece is a
// model without photographs, in small chunks, so that no program need read more of the city than it works on.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "atlas/model/surface/chunked_surface.h"
#include "tools/city/city_plan.h"

namespace lumatlas {

class CitySurface {
 public:
  // Lists the files of a plan's folder. Throws InputError.
  explicit CitySurface(const std::filesystem::path& plan);

  [[nodiscard]] std::size_t count() const { return files_.size(); }  // of chunks
  // Returns how many chunks each piece has.
  [[nodiscard]] const std::vector<std::size_t>& chunks_of_pieces() const { return chunks_of_pieces_; }
  // Reads these chunks, whose numbers count over all pieces. The first chunk holds the far sphere. Throws InputError
  // naming the first file that breaks a rule, or a number that there is not.
  [[nodiscard]] ChunkedSurface read(std::span<const std::size_t> chunks) const;

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
  std::vector<std::size_t> chunks_of_pieces_;
};

// Writes the next piece into a plan's folder, in chunks of at most `chunk_faces` faces or one cell. The pieces of a
// plan have the same offset and size of cells, and the first alone may have a far sphere. Throws InputError.
void write_surface_piece(const std::filesystem::path& plan, std::size_t number, const Surface& surface,
                         std::size_t chunk_faces);

// Removes the pieces of a plan's folder, which an earlier program may have left there.
void clear_surface(const std::filesystem::path& plan);

// Returns the sizes and boxes of chunks that were read.
[[nodiscard]] std::vector<CityChunk> describe_chunks(const ChunkedSurface& surface);

}  // namespace lumatlas
