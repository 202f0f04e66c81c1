// SPDX-License-Identifier: GPL-3.0-or-later
// Videos as files, read by the programs ffmpeg and ffprobe: a damaged video can end these, and not this program.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace lumatlas {

// Returns whether the file's ending, in any case, is one that videos have.
[[nodiscard]] bool has_video_ending(const std::filesystem::path& file);

// The facts that ffprobe reports of the first video stream.
struct VideoFacts {
  double seconds = 0;            // 0: not said
  double frames_per_second = 0;  // on average; 0: not said
  std::uint64_t frames = 0;      // about, for progress; 0: not said
  bool is_hdr = false;           // its brightness is coded by PQ or HLG, and not for the displays that sRGB is for
};

class VideoFile {
 public:
  // `work`: a folder for what ffmpeg says, which stays there where it fails. Throws InputError where PATH lacks ffmpeg
  // or ffprobe, with what to install, and where the file has no video stream.
  VideoFile(std::filesystem::path file, std::filesystem::path work);

  [[nodiscard]] const VideoFacts& facts() const { return facts_; }

  // Calls `look` with the grey values of each frame in turn, upright, scaled down to at most `longer_px` pixels on its
  // longer side. What `look` throws ends ffmpeg and is thrown on. If a video is cut off, the frames before the cut are
  // used. Throws InputError where no frame can be read, and Interrupted.
  using Look = std::function<void(std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height)>;
  void for_each_grey_frame(std::uint32_t longer_px, const Look& look) const;

  // Writes the frames of these indices, ascending, in the order of for_each_grey_frame(), as JPEG files of high quality
  // in sRGB, upright; files[i] gets frame indices[i] and appears whole. `tick` is called now and then with how many are
  // written. Throws InputError, also where the video has fewer frames, and Interrupted.
  void write_frames(std::span<const std::size_t> indices, std::span<const std::filesystem::path> files,
                    const std::function<void(std::size_t)>& tick) const;

  // Returns the first line in which ffmpeg told of damage when it last read the whole video; empty: it told of none.
  [[nodiscard]] std::string damage() const;

 private:
  // Returns ffmpeg's exit status, or minus the signal that ended it.
  int run_ffmpeg(const std::vector<std::string>& arguments, const std::filesystem::path& out,
                 const std::function<void()>& while_waiting) const;
  // The end of a sentence: why ffmpeg failed, and where it says more.
  [[nodiscard]] std::string reason(int status) const;
  [[nodiscard]] std::filesystem::path words() const { return work_ / "ffmpeg.txt"; }
  void probe();

  std::filesystem::path file_, work_, ffmpeg_;
  VideoFacts facts_;
};

}  // namespace lumatlas
