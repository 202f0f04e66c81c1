// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/picture_output.h"

#include <algorithm>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace fs = std::filesystem;

namespace {

constexpr const char* kVideoName = "video.mp4";
constexpr std::size_t kLongestName = 255;  // bytes; of all file systems in use

const char* ending_of(PictureFormat format) {
  return format == PictureFormat::exr ? ".exr" : ".png";
}

// A file's name, without its ending, that tells as much of a view's name as there is room for.
std::string own_name(std::string name, std::size_t number) {
  constexpr std::size_t kMostKept = 200;  // bytes
  std::replace(name.begin(), name.end(), '/', '_');
  const auto continues_character = [](char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; };
  std::size_t length = std::min(name.size(), kMostKept);
  while (length > 0 && length < name.size() && continues_character(name[length])) --length;
  return name.substr(0, length) + "-" + std::to_string(number);
}

}  // namespace

PictureOutput::PictureOutput(fs::path folder, PictureFormat format, double frames_per_second)
    : folder_(std::move(folder)), format_(format), frames_per_second_(frames_per_second) {
  if (format == PictureFormat::mp4) ffmpeg_ = find_ffmpeg();
}

fs::path PictureOutput::file_for_view(const std::string& name) {
  fs::path path = fs::path(name).replace_extension(ending_of(format_));
  if (!is_free(path)) path = name + ending_of(format_);
  for (std::size_t number = 1; !is_free(path); ++number) path = own_name(name, number) + ending_of(format_);
  taken_.insert(path);
  for (fs::path folder = path.parent_path(); !folder.empty(); folder = folder.parent_path()) folders_.insert(folder);
  return path;
}

bool PictureOutput::is_free(const fs::path& file) const {
  const auto is_too_long = [](const fs::path& part) { return part.native().size() > kLongestName; };
  if (std::any_of(file.begin(), file.end(), is_too_long) || taken_.contains(file) || folders_.contains(file)) {
    return false;
  }
  fs::path folder = file.parent_path();
  while (!folder.empty() && !taken_.contains(folder)) folder = folder.parent_path();
  return folder.empty();
}

fs::path PictureOutput::file_for_frame(std::size_t index, std::size_t count) const {
  const std::size_t digits = std::max<std::size_t>(5, std::to_string(count - 1).size());
  std::string number = std::to_string(index);
  number.insert(0, digits - number.size(), '0');
  return number + ending_of(format_);
}

void PictureOutput::write(const fs::path& file, const SoftPicture& picture) {
  if (format_ == PictureFormat::mp4) {
    write_frame(picture.picture);
    return;
  }
  const fs::path path = folder_ / file;
  fs::create_directories(path.parent_path());
  write_image(path, picture.picture, picture.alpha);
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
                     std::to_string(video_height_) + " and " + size_text(picture.width, picture.height) +
                     ", a video has one: write pictures (--format png)");
  }
  video_->write(picture);
}

void PictureOutput::finish() {
  if (video_) video_->finish();
}

}  // namespace lumatlas
