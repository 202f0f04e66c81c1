// SPDX-License-Identifier: GPL-3.0-or-later
// Finds what can be captured in a folder, or takes a video alone.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace lumatlas {

// All names are relative to `folder`, with '/', in byte order.
struct CaptureSources {
  std::filesystem::path folder;          // absolute; of a video, the folder that it lies in
  std::vector<std::string> photographs;  // that COLMAP reads as they are: JPEG, PNG, TIFF, WebP
  std::vector<std::string> converted;    // that it does not: HEIC, AVIF, and the raw forms of cameras
  std::vector<std::string> videos;
  std::map<std::string, std::string> left_out;  // by name, why: the end of a sentence about the file
};

// Looks into the folder and those below, by the endings of files; hidden files and folders, and the folder `masks`
// where it is not empty, are passed over. Left out are pictures in forms that are not read, a raw or HEIC photograph
// beside a JPEG of the same name, and a video beside a photograph of the same name, which phones keep with it.
// Throws InputError where `given` is neither a folder nor a video, where it holds fewer than two photographs and no
// video, and for a name that COLMAP's list of photographs or a model cannot hold.
[[nodiscard]] CaptureSources find_sources(const std::filesystem::path& given, const std::filesystem::path& masks);

}  // namespace lumatlas
