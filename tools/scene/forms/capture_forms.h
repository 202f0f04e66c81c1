// SPDX-License-Identifier: GPL-3.0-or-later
// The forms in which programs and apps leave posed photographs, and which of them a folder has.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/scene/forms/capture.h"

namespace lumatlas {

struct CaptureForm {
  std::string name;                                // such as "COLMAP"
  std::filesystem::path file;                      // the file that the form is recognised by
  Capture (*read)(const CaptureRequest& request);  // throws InputError
};

// The forms in the folder `scene`, the one to read first: COLMAP, then those that say most of lenses and names, then
// bare trajectories. Never throws: what cannot be looked at is not there.
[[nodiscard]] std::vector<CaptureForm> forms_in(const std::filesystem::path& scene);

// Returns a sentence about a folder with several forms, else an empty string.
[[nodiscard]] std::string other_forms_note(const std::vector<CaptureForm>& forms);

// The capture in the folder, by the first of its forms: each photograph is where this computer has it, and each full
// panorama is cut into views (tools/scene/forms/panorama.h). Throws InputError, also where there is none.
[[nodiscard]] Capture read_capture(const CaptureRequest& request);

}  // namespace lumatlas
