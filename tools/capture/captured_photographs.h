// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of a folder, before anybody knows where they were taken.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace lumatlas {

struct CapturedPhotographs {
  std::filesystem::path folder;    // absolute
  std::vector<std::string> names;  // relative to the folder, with '/', in byte order
};

// Everything in the folder, and in folders below, whose name ends as those of JPEG, PNG, TIFF and WebP files do; hidden
// files and folders are passed over. Throws InputError where there is no such folder, or it has fewer than two.
[[nodiscard]] CapturedPhotographs find_photographs(const std::filesystem::path& folder);

// Name, size and time of each: what tells that a photograph came, went or changed.
[[nodiscard]] nlohmann::json states_of(const CapturedPhotographs& photographs);

// Whether all were taken through the same lens, as far as their headers tell: the same size, camera and focal length.
// Photographs that say nothing of their camera count as of the same one.
[[nodiscard]] bool of_one_lens(const CapturedPhotographs& photographs);

}  // namespace lumatlas
