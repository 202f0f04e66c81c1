// SPDX-License-Identifier: GPL-3.0-or-later
// Bundler's cameras, bundle.out of version 0.3, with its list of photographs.
//
//   bundle file  a line "# Bundle file v0.3", the counts of cameras and points, then of each camera f k1 k2, the
//                rotation R by rows, and t; then the points
//   list.txt     the photographs in the order of the cameras, one a line: the file, then optionally 0 and a focal
//                length
//   pose         P = R X + t, with the camera looking along -z, x right and y up
//   lens         f (1 + k1 p^2 + k2 p^4) p for p = -P / P.z, in pixels from the middle of the photograph
//
// A camera with f = 0 was not placed: it is left out and counted. The size of the photographs is not stated:
// measured_size.h says what is assumed. Only the points' measurements in the photographs are read.
//
// Source: Snavely, "Bundler v0.4 User's Manual", section "Output format".
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"

namespace lumatlas {

// `list` holds the contents of the list of photographs at `list_path`. Throws InputError that names file and line, and
// what the lookup throws. Allocates no more than a small multiple of the bytes that it is given. Where bad photographs
// are kept, these are the ones with a pose or a lens that cannot be.
[[nodiscard]] Capture parse_bundler(std::string_view text, const std::filesystem::path& path, std::string_view list,
                                    const std::filesystem::path& list_path, const PhotographLookup& photographs);

// bundle.out, bundle.rd.out or bundle/bundle.out, the first that begins with "# Bundle file".
[[nodiscard]] std::optional<std::filesystem::path> find_bundler(const std::filesystem::path& scene);

// The list is list.txt beside the bundle file or, where that is in bundle/, one folder up; of bundle.rd.out it is
// list.rd.txt if there is one. Throws InputError if there is none: the order of files in a folder is not that of the
// cameras.
[[nodiscard]] Capture read_bundler(const CaptureRequest& request);

}  // namespace lumatlas
