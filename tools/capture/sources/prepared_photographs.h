// SPDX-License-Identifier: GPL-3.0-or-later
// Makes photographs that COLMAP reads of what lies in a folder: of frames of videos, and of photographs in other forms.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/capture/sources/capture_sources.h"
#include "tools/capture/sources/captured_photographs.h"
#include "tools/meshing/scene_mesh.h"

namespace lumatlas {

struct CapturedVideo {
  std::string name;
  std::size_t frames = 0;  // that it has
  std::size_t taken = 0;   // how many of these were taken
  double seconds = 0;      // 0: not known
  std::string damage;      // FFmpeg's words of it; empty: none
};

struct PreparedPhotographs {
  CapturedPhotographs captured;
  std::vector<CapturedVideo> videos;            // sorted by name
  double step = 0;                              // see FrameChoiceOptions; 0 without videos
  std::size_t converted = 0;                    // photographs of other forms
  std::map<std::string, std::string> left_out;  // for each name the reason: the sources' and those that cannot be read
  bool made_anything = false;                   // false where an earlier run left all of it
};

struct PreparationListener {
  std::function<void(const std::string& sentence)> say;
  StageProgress stage;
};

// Returns whether COLMAP cannot read all sources as they are.
[[nodiscard]] bool need_preparation(const CaptureSources& sources);

// Makes the folder work/images from the sources; COLMAP and every command read it. It has links to photographs that
// COLMAP reads as they are (copies, if the file system has no links); NAME.jpg for a converted photograph NAME, with
// the camera and position of its header; and VIDEO/FRAME.jpg for the frames of a video, at most `most_frames` of all
// videos together. A photograph keeps its name whatever lies beside it, so that COLMAP's database stays good when
// videos or other forms are added. What an earlier run left there of the same files is kept, also in
// earlier_photographs(), and so are motions of videos, in work/videos. Photographs that cannot be read are left out.
// Throws InputError for a video that cannot be read and where fewer than two photographs are left, and Interrupted.
[[nodiscard]] PreparedPhotographs prepare_photographs(const CaptureSources& sources, const std::filesystem::path& work,
                                                      std::size_t most_frames, const PreparationListener& listener);

// Returns the folder in which earlier versions made photographs; work/images was a link then, to it or to the user's.
[[nodiscard]] std::filesystem::path earlier_photographs(const std::filesystem::path& work);

}  // namespace lumatlas
