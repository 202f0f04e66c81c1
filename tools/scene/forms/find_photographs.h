// SPDX-License-Identifier: GPL-3.0-or-later
// Where the photographs of a capture are on this computer.
//
// A form names photographs as they lay where it was written: with a drive's letter, with backslashes, in a folder that
// is called otherwise here, with another ending, or with accents that a file system has taken apart.
#pragma once

#include <filesystem>
#include <optional>

#include "tools/scene/forms/capture.h"

namespace lumatlas {

// Sets PosedPhotograph::name and ::file to those of the file that is there. A photograph that is where its form says
// stays as it is. Others are looked for in `images`, else in the scene's folder images/, else in the scene's folder and
// those below, among the pictures that the form names nowhere else: taken is the only one whose path is the longest end
// of the named path, else the only one that is so without its ending and without regard to capitals and to how accents
// are written. A note says how many were found like this. A photograph that is not found keeps its name, or where that
// leads out of the folder, the last part of it.
//
// Sorts by name again. Throws InputError that begins with `path` where a name may be several photographs, and where
// two names are one photograph, unless bad ones are kept.
void find_photographs(Capture& capture, const std::filesystem::path& path, const std::filesystem::path& scene,
                      const std::optional<std::filesystem::path>& images, BadPhotographs bad);

}  // namespace lumatlas
