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
  std::filesystem::path given;           // the user's name for it, for sentences
  std::filesystem::path folder;          // absolute; of a video, the folder that it lies in
  std::vector<std::string> photographs;  // that COLMAP reads as they are: JPEG, PNG, TIFF, WebP
  std::vector<std::string> converted;    // that it does not: HEIC, AVIF, and the raw forms of cameras
  std::vector<std::string> videos;
  std::map<std::string, std::string> left_out;  // for each name the reason: the end of a sentence about the file
};

// Returns the name of the JPEG file that is made of a photograph in another form: "IMG_1.HEIC.jpg" of "IMG_1.HEIC".
[[nodiscard]] std::string name_of_converted(const std::string& name);

// Looks into the folder and those below, also through links, by the endings of files; hidden files and folders, and the
// folder `masks` where it is not empty, are passed over. Left out are pictures in forms that are not read, a raw or
// HEIC photograph beside a JPEG of the same name or beside NAME.jpg, and a video beside a photograph of the same name,
// which phones keep with it.
// Throws InputError where `given` is neither a folder nor a video, where it holds fewer than two photographs and no
// video, and for a name that COLMAP's list of photographs or a model cannot hold.
[[nodiscard]] CaptureSources find_sources(const std::filesystem::path& given, const std::filesystem::path& masks);

}  // namespace lumatlas
