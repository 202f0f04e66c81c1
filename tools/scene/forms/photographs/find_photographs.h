// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the photographs of a capture on this computer.
//
// A form names photographs as they lay where it was written: with a drive's letter, with backslashes, in a folder that
// is called otherwise here, with another ending, or with accents that a file system has taken apart.
#pragma once

#include <filesystem>
#include <optional>

#include "tools/scene/forms/capture.h"

namespace lumatlas {

// Sets PosedPhotograph::name and ::file to those of a file that exists. A photograph that is where its form says stays
// as it is. The others are looked for in `images`, else in the scene's folder images/, else in the scene's folder and
// all below it; pictures that the form names elsewhere are no candidates. The picture with the longest end of the named
// path is taken, regardless of its ending, of capitals and of how accents are encoded, if it is the only one. A note
// tells how many photographs were found like this. A photograph that is not found keeps its name, or the last part of
// it where the name leads out of the folder. No name and no file leads out of its folder afterwards.
//
// Sorts by name again. Throws InputError that begins with `path` where several pictures fit a name, and where two names
// are one photograph; if bad photographs are kept, the first become bad, and of the second one is left out.
void find_photographs(Capture& capture, const std::filesystem::path& path, const std::filesystem::path& scene,
                      const std::optional<std::filesystem::path>& images, BadPhotographs bad);

}  // namespace lumatlas
