// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/picture_output.h"

#include <algorithm>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace fs = std::filesystem;

namespace {

constexpr const char* kVideoName = "video.mp4";

const char* ending_of(PictureFormat format) {
  return format == PictureFormat::exr ? ".exr" : ".png";
}

}  // namespace

PictureOutput::PictureOutput(fs::path folder, PictureFormat format, double frames_per_second)
    : folder_(std::move(folder)), format_(format), frames_per_second_(frames_per_second) {
  if (format == PictureFormat::mp4) ffmpeg_ = find_ffmpeg();
}

fs::path PictureOutput::file_for_view(const std::string& name) {
  fs::path path = name;
  path.replace_extension(ending_of(format_));
  if (!taken_.insert(path).second) {
    path = name + ending_of(format_);
    taken_.insert(path);
  }
  return path;
}

fs::path PictureOutput::file_for_frame(std::size_t index, std::size_t count) const {
  const std::size_t digits = std::max<std::size_t>(5, std::to_string(count - 1).size());
  std::string number = std::to_string(index);
  number.insert(0, digits - number.size(), '0');
  return number + ending_of(format_);
}

void PictureOutput::write(const fs::path& file, const Photograph& picture) {
  if (format_ == PictureFormat::mp4) {
    write_frame(picture);
    return;
  }
  const fs::path path = folder_ / file;
  fs::create_directories(path.parent_path());
  write_image(path, picture);
}

void PictureOutput::write(const fs::path& file, const FloatImage& image) {
  const fs::path path = folder_ / file;
  fs::create_directories(path.parent_path());
  write_float_image(path, image);
}

void PictureOutput::write_frame(const Photograph& picture) {
  if (!video_) {
    video_width_ = picture.width;
    video_height_ = picture.height;
    video_ =
        std::make_unique<FfmpegPipe>(ffmpeg_, folder_ / kVideoName, picture.width, picture.height, frames_per_second_);
  }
  if (picture.width != video_width_ || picture.height != video_height_) {
    throw InputError("the views are of different sizes, " + std::to_string(video_width_) + "x" +
                     std::to_string(video_height_) + " and " + std::to_string(picture.width) + "x" +
                     std::to_string(picture.height) + ", a video has one: write pictures (--format png)");
  }
  video_->write(picture);
}

void PictureOutput::finish() {
  if (video_) video_->finish();
}

}  // namespace lumatlas
