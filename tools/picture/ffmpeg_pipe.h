// SPDX-License-Identifier: GPL-3.0-or-later
// Videos by the program ffmpeg, if it is there: frames go into its standard input, one after another.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "atlas/images/photograph.h"

namespace lumatlas {

// The program that PATH has. Throws InputError, with what to do, if it has none.
[[nodiscard]] std::filesystem::path find_ffmpeg();

class FfmpegPipe {
 public:
  // H.264 in an MP4 file, which ffmpeg writes to `file`: 4:2:0, BT.709, sizes that are odd get one more black row or
  // column. Throws InputError if ffmpeg cannot be started, std::invalid_argument for a size of 0 or a rate that is not
  // finite and positive.
  FfmpegPipe(const std::filesystem::path& ffmpeg, const std::filesystem::path& file, std::uint32_t width,
             std::uint32_t height, double frames_per_second);
  ~FfmpegPipe();  // without finish(), ffmpeg is stopped
  FfmpegPipe(const FfmpegPipe&) = delete;
  FfmpegPipe& operator=(const FfmpegPipe&) = delete;

  // The frame must have the size that was given (std::invalid_argument). Throws InputError, with ffmpeg's own last
  // words, if it has gone.
  void write(const Photograph& frame);
  // Waits for ffmpeg to end. Throws InputError, with its last words, unless it has succeeded.
  void finish();

 private:
  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  [[noreturn]] void fail(const std::string& what);
  int wait();

  std::filesystem::path file_;
  std::uint32_t width_, height_;
  std::unique_ptr<std::FILE, CloseFile> log_;  // ffmpeg's stderr
  int input_ = -1;                             // our end
  pid_t child_ = -1;
};

}  // namespace lumatlas
