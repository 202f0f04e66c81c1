// SPDX-License-Identifier: GPL-3.0-or-later
// What the binary and the text reader of COLMAP's models share: the rules that a record obeys, and the sentences.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/scene/forms/colmap.h"

namespace lumatlas::colmap {

// Where in a file something is wrong.
struct Place {
  const std::filesystem::path& path;
  const char* unit;      // "line", "the camera at index", ...
  std::uint64_t number;  // lines from 1, indices from 0
};

// InputError "PATH: UNIT NUMBER: REASON".
[[noreturn]] void fail(const Place& place, const std::string& reason);

// The text in quotes, on one line and shortened, whatever its bytes are.
[[nodiscard]] std::string escaped_in_quotes(std::string_view text);

// Throws InputError unless `lens` passes check().
void check_camera(const ColmapCamera& camera, const Place& place);

// Normalises the quaternion (w, x, y, z). Throws InputError for a zero or non-finite one, for a translation that is not
// finite or beyond 1e12, and for a name that is empty, absolute, leaves its folder or holds control characters.
[[nodiscard]] ColmapImage checked_image(std::uint32_t id, const std::array<double, 4>& quaternion,
                                        const std::array<double, 3>& translation, std::uint32_t camera_id,
                                        std::string_view name, const Place& place);

// Throws InputError for a position that is not finite or beyond 1e12.
void check_point(const ColmapPoint& point, const Place& place);

// Throw InputError if an id or a name occurs twice.
void check_unique(const std::vector<ColmapCamera>& cameras, const std::filesystem::path& path);
void check_unique(const std::vector<ColmapImage>& images, const std::filesystem::path& path);

}  // namespace lumatlas::colmap
