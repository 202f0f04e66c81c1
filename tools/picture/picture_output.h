// SPDX-License-Identifier: GPL-3.0-or-later
// The destination of rendered pictures: files of their own, or frames of a video.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "atlas/images/float_image.h"
#include "atlas/images/photograph.h"
#include "tools/frame/background.h"
#include "tools/picture/ffmpeg_pipe.h"

namespace lumatlas {

enum class PictureFormat {
  png,  // 8-bit sRGB
  exr,  // 32-bit floats: linear light, or a mode's numbers
  mp4,  // all in one file, video.mp4
};

class PictureOutput {
 public:
  // Throws InputError at once if a video is asked for and ffmpeg is not there.
  PictureOutput(std::filesystem::path folder, PictureFormat format, double frames_per_second);

  // The file that a view's picture is written to: its name in the scene with another ending. Two photographs may differ
  // in nothing but their ending: the second keeps it before the new one. Where that name is too long for a file, or a
  // folder of another view has it, the picture gets a name of its own in the output folder.
  [[nodiscard]] std::filesystem::path file_for_view(const std::string& name);
  // The same for a frame of a path: its number, padded to five digits or to what the last one of `count` needs.
  [[nodiscard]] std::filesystem::path file_for_frame(std::size_t index, std::size_t count) const;

  // Writes the colours for png and mp4. mp4 ignores `file` and alpha, and all frames of a video must have one size
  // (InputError).
  void write(const std::filesystem::path& file, const SoftPicture& picture);
  void write(const std::filesystem::path& file, const FloatImage& image);  // for exr
  void finish();                                                           // once, after the last

 private:
  void write_frame(const Photograph& picture);

  std::filesystem::path folder_;
  PictureFormat format_;
  double frames_per_second_;
  std::filesystem::path ffmpeg_;
  std::unique_ptr<FfmpegPipe> video_;
  std::uint32_t video_width_ = 0, video_height_ = 0;
  [[nodiscard]] bool is_free(const std::filesystem::path& file) const;

  std::set<std::filesystem::path> taken_;    // files
  std::set<std::filesystem::path> folders_;  // around them
};

}  // namespace lumatlas
