// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of a capture as COLMAP reads them, before it is known where they were taken.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas {

struct CapturedPhotograph {
  std::string name;       // relative to the folder, with '/'
  std::string video;      // that it is a frame of, by name; empty: of none
  CameraNote note;        // from its header; empty for a frame, or if that cannot be read
  std::string converted;  // the file that it was converted from, relative to the source folder; empty: it was not
};

struct CapturedPhotographs {
  std::filesystem::path given;  // the user's name for it, for sentences
  std::filesystem::path
      source_folder;             // the folder that the user named or, for a video, the folder around it; absolute
  std::filesystem::path folder;  // the folder that COLMAP reads, absolute
  std::vector<CapturedPhotograph> photographs;  // sorted by name, in byte order; frames of a video in order of time
};

[[nodiscard]] std::vector<std::string> names_of(const CapturedPhotographs& captured);

// Returns name, size and time of each, which tell that a photograph came, went or changed.
[[nodiscard]] nlohmann::json states_of(const CapturedPhotographs& captured);

// Returns the names of the photographs by the lens that they were taken through, as far as their headers tell: of one
// size, camera and focal length. The frames of a video count as of one lens of its own. Photographs that say nothing of
// their camera count as of one where they have one size, and those that cannot be read as of the lens of most. The lens
// of most photographs is the first, of equals the one of the first name; names are in byte order.
[[nodiscard]] std::vector<std::vector<std::string>> names_by_lens(const CapturedPhotographs& captured);

}  // namespace lumatlas
