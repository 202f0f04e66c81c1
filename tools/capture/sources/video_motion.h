// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how the frames of a video move, and keeps that in a file so that a video is measured once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/meshing/scene_mesh.h"
#include "tools/video/video_file.h"
#include "tools/video/video_frame.h"

namespace lumatlas {

struct VideoMotion {
  std::vector<VideoFrame> frames;
  std::string damage;  // FFmpeg's words of it; empty: none
};

// Reads what an earlier call left in `kept` for the same file, by size and time, or measures it and writes it there.
// Throws InputError and Interrupted.
[[nodiscard]] VideoMotion motion_of(const VideoFile& video, const std::filesystem::path& file,
                                    const std::filesystem::path& kept, const StageProgress& stage);

}  // namespace lumatlas
