// SPDX-License-Identifier: GPL-3.0-or-later
// Reads what COLMAP's mapper leaves: one reconstruction, or several that do not hang together.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace lumatlas {

struct Reconstruction {
  std::filesystem::path folder;
  std::vector<std::string> placed;  // names of photographs, in byte order
};

// Returns those in the folder, the one of most photographs first; of equals, the one that COLMAP began first. Throws
// InputError where one cannot be read.
[[nodiscard]] std::vector<Reconstruction> reconstructions_in(const std::filesystem::path& folder);

// Returns the files of COLMAP's model in a folder of its own, in binary or as text, whether they are there or not.
[[nodiscard]] std::vector<std::filesystem::path> files_of_model(const std::filesystem::path& folder);

}  // namespace lumatlas
