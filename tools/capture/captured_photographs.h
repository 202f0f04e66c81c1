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
// files and folders are passed over. Throws InputError where there is no such folder, where it has fewer than two, and
// for a name that COLMAP's list of photographs or a model cannot hold.
[[nodiscard]] CapturedPhotographs find_photographs(const std::filesystem::path& folder);

// Name, size and time of each: what tells that a photograph came, went or changed.
[[nodiscard]] nlohmann::json states_of(const CapturedPhotographs& photographs);

// The names of the photographs by the lens that they were taken through, as far as their headers tell: of one size,
// camera and focal length. Photographs that say nothing of their camera count as of one where they have one size, and
// those that cannot be read as of the lens of most. The lens of most photographs is the first, of equals the one of the
// first name; names are in byte order.
[[nodiscard]] std::vector<std::vector<std::string>> names_by_lens(const CapturedPhotographs& photographs);

}  // namespace lumatlas
