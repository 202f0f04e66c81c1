// SPDX-License-Identifier: GPL-3.0-or-later
// The small model whose site the page's tests show in a browser.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "mesh/camera/camera.h"
#include "tools/viewer/site.h"

namespace lumatlas {

inline constexpr std::size_t kSiteViews = 12;
inline constexpr std::size_t kStoredPoses = 10;  // poses of stored views
inline constexpr std::size_t kNewPoses = 10;     // poses between and beyond them

// With gains, so that the exposure of pictures shows.
[[nodiscard]] Snapshot site_model();

// Cameras at the stored poses, then at the new ones.
[[nodiscard]] std::vector<Camera> site_cameras();

[[nodiscard]] SiteFile text_file(const std::string& name, const std::string& type, const std::string& text);

// Cameras as the page's scripts read them: "cameras.json".
[[nodiscard]] SiteFile cameras_file(const std::vector<Camera>& cameras = site_cameras());

// A page of the tests from their folder, and what such pages share: "test.html", "test_page.js".
[[nodiscard]] std::vector<SiteFile> test_page_files(const std::string& html);

// The site of a model, with photographs as PNG, so that pictures can be compared without JPEG's noise.
[[nodiscard]] std::vector<SiteFile> site_files(const Snapshot& model = site_model(),
                                               std::size_t chunk_faces = SiteOptions{}.chunk_faces,
                                               std::size_t coarse_faces = SiteOptions{}.coarse_faces,
                                               std::size_t listed_views = SiteOptions{}.listed_views);

[[nodiscard]] SiteFile in_folder(const std::string& folder, SiteFile file);

}  // namespace lumatlas
