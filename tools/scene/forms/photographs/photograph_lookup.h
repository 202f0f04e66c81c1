// SPDX-License-Identifier: GPL-3.0-or-later
// Access to photographs on disk for the parsers of forms of capture.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string_view>

#include "atlas/images/photograph.h"
#include "tools/scene/forms/capture.h"

namespace lumatlas {

// The questions that a parser asks about photographs, so that it opens no files itself.
struct PhotographLookup {
  // The photograph that a form calls `label`, see PhotographNames::find_by_path(). Throws InputError for a label that
  // is several photographs.
  std::function<PosedPhotograph(std::string_view label)> find;
  // Returns the size in pixels, as stored. For a photograph that cannot be read it returns the size of one beside it,
  // so that a scene can be listed whole, and the fault is reported when the photograph is needed. Throws InputError if
  // there is none.
  std::function<ImageSize(const PosedPhotograph&)> size_of;
  BadPhotographs bad = BadPhotographs::refuse;
};

// Returns a PhotographLookup::size_of that looks at the photograph of that name in `images` if it is given, else at its
// file in the scene's folder.
[[nodiscard]] std::function<ImageSize(const PosedPhotograph&)> sizes_in(
    const std::filesystem::path& scene, const std::optional<std::filesystem::path>& images);

// Looks in CaptureRequest::images if it is given, else in the scene's folder images/, else in the scene's folder.
[[nodiscard]] PhotographLookup photographs_of(const CaptureRequest& request);

}  // namespace lumatlas
