// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/video: grey pictures that another program writes one after another, read while it writes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

namespace lumatlas {

// A named pipe that PGM pictures of 8 bits are written to. It goes with this object.
class GreyStream {
 public:
  using Look = std::function<void(std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height)>;

  // Makes the pipe at `path`, in the place of what is there. Throws InputError.
  GreyStream(std::filesystem::path path, const Look& look);
  ~GreyStream();
  GreyStream(const GreyStream&) = delete;
  GreyStream& operator=(const GreyStream&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::size_t frames() const { return frames_; }  // that `look` was called with

  // Reads what has been written so far, without waiting, and looks at the frames that are whole. Throws InputError for
  // what is no PGM picture, and what `look` throws.
  void read();

 private:
  [[nodiscard]] bool look_at_one();

  std::filesystem::path path_;
  const Look& look_;
  int file_ = -1;
  std::vector<std::uint8_t> bytes_;
  std::size_t frames_ = 0;
};

}  // namespace lumatlas
