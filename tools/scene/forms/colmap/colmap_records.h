// SPDX-License-Identifier: GPL-3.0-or-later
// Shared by the binary and the text reader of COLMAP's models: the rules that a record obeys, and the sentences.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/scene/forms/colmap/colmap.h"

namespace lumatlas::colmap {

// The position of a fault in a file.
struct FileLocation {
  const std::filesystem::path& path;
  const char* unit;      // "line", "the camera at index", ...
  std::uint64_t number;  // lines from 1, indices from 0
};

// InputError "PATH: UNIT NUMBER: REASON".
[[noreturn]] void fail(const FileLocation& place, const std::string& reason);

// The text in quotes, on one line and shortened, whatever its bytes are.
[[nodiscard]] std::string escaped_in_quotes(std::string_view text);

// Throws InputError unless the lens passes check(); where bad ones are kept, sets ColmapCamera::bad instead.
void check_camera(ColmapCamera& camera, const FileLocation& place, BadPhotographs bad);

// Normalises the quaternion (w, x, y, z). Throws InputError for a name that is empty or holds control characters. For a
// quaternion that is zero or not finite and for a translation that is not finite or beyond 1e12 it throws too, or sets
// ColmapImage::bad where bad ones are kept.
[[nodiscard]] ColmapImage checked_image(std::uint32_t id, const std::array<double, 4>& quaternion,
                                        const std::array<double, 3>& translation, std::uint32_t camera_id,
                                        std::string_view name, const FileLocation& place, BadPhotographs bad);

// Throws InputError for a position that is not finite or beyond 1e12.
void check_point(const ColmapPoint& point, const FileLocation& place);

// Throw InputError if an id occurs twice, or, unless bad ones are kept, a name.
void check_unique(const std::vector<ColmapCamera>& cameras, const std::filesystem::path& path);
void check_unique(const std::vector<ColmapImage>& images, const std::filesystem::path& path, BadPhotographs bad);

}  // namespace lumatlas::colmap
