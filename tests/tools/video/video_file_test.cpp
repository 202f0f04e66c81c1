// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/video_file.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/video/textured_wall.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

constexpr std::uint32_t kVideoWidth = 160, kVideoHeight = 96;
constexpr std::size_t kVideoFrames = 24;

// A video of a camera that moves along a wall by two pixels a frame, with `more` of ffmpeg's arguments.
fs::path walled_video(const TemporaryFolder& folder, const std::string& name, std::vector<std::string> more) {
  const TexturedWall wall(7);
  fs::create_directories(folder / "pictures");
  for (std::size_t i = 0; i < kVideoFrames; ++i) {
    write_image(folder / "pictures" / (std::to_string(100 + i) + ".png"),
                wall.photograph(kVideoWidth, kVideoHeight, 20 + 2.0 * static_cast<double>(i), 30));
  }
  std::vector<std::string> arguments{"-y",
                                     "-loglevel",
                                     "error",
                                     "-start_number",
                                     "100",
                                     "-framerate",
                                     "25",
                                     "-i",
                                     (folder / "pictures" / "%03d.png").string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  arguments.push_back((folder / name).string());
  REQUIRE(run_to_end({find_program("ffmpeg"), arguments, folder / "out.txt", folder / "err.txt"}) == 0);
  return folder / name;
}

const std::vector<std::string> kSharpH264{
    "-c:v",     "libx264", "-crf",        "8",     "-vf",          "scale=out_color_matrix=bt709:out_range=tv",
    "-pix_fmt", "yuv420p", "-colorspace", "bt709", "-color_range", "tv"};

bool has_ffmpeg() {
  if (!find_program("ffmpeg").empty() && !find_program("ffprobe").empty()) return true;
  skip("FFmpeg is not installed");
  return false;
}

// The root of the mean squared difference of the middle of two pictures of one size.
double middle_difference(const Photograph& a, const Photograph& b) {
  REQUIRE(a.width == b.width);
  REQUIRE(a.height == b.height);
  double sum = 0;
  std::size_t count = 0;
  for (std::uint32_t y = 8; y < a.height - 8; ++y) {
    for (std::uint32_t i = 3 * 8; i < 3 * (a.width - 8); ++i, ++count) {
      const std::size_t at = std::size_t{3} * a.width * y + i;
      sum += std::pow(double{1} * a.rgb[at] - b.rgb[at], 2);
    }
  }
  return std::sqrt(sum / static_cast<double>(count));
}

TEST_CASE("each frame of a video is looked at, and those that are asked for are written in its colours") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  const VideoFile video(walled_video(folder, "walk.mp4", kSharpH264), folder / "w%d");
  CHECK(video.facts().frames == kVideoFrames);
  CHECK(video.facts().frames_per_second == Approx(25));
  CHECK(video.facts().seconds == Approx(kVideoFrames / 25.0));
  CHECK_FALSE(video.facts().is_hdr);
  std::size_t frames = 0;
  video.for_each_grey_frame(80, [&](std::span<const std::uint8_t> grey, std::uint32_t width, std::uint32_t height) {
    ++frames;
    CHECK(width == 80);
    CHECK(height == 48);
    CHECK(grey.size() == 80 * 48);
  });
  CHECK(frames == kVideoFrames);
  CHECK(video.damage().empty());

  const std::vector<std::size_t> indices{0, 7, 23};
  const std::vector<fs::path> files{folder / "a.jpg", folder / "b.jpg", folder / "c.jpg"};
  std::size_t told = 0;
  video.write_frames(indices, files, [&](std::size_t written) { told = written; });
  CHECK(told == 3);
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Photograph shown = read_photograph(folder / "pictures" / (std::to_string(100 + indices[i]) + ".png"));
    const Photograph neighbor =
        read_photograph(folder / "pictures" / (std::to_string(indices[i] == 0 ? 101 : 99 + indices[i]) + ".png"));
    const Photograph written = read_photograph(files[i]);
    CHECK(middle_difference(written, shown) < 4);
    CHECK(middle_difference(written, shown) < 0.5 * middle_difference(written, neighbor));
  }
  CHECK_FALSE(fs::exists(folder / "w%d" / "chosen"));
}

TEST_CASE("hundreds of frames may be asked for at once") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  REQUIRE(run_to_end({find_program("ffmpeg"),
                      {"-y", "-f", "lavfi", "-i", "testsrc=duration=24:size=64x48:rate=25", "-c:v", "mpeg4",
                       (folder / "long.avi").string()},
                      folder / "out.txt",
                      folder / "err.txt"}) == 0);
  const VideoFile video(folder / "long.avi", folder / "work");
  std::vector<std::size_t> indices;
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < 599; i += 2) {
    indices.push_back(i);
    files.push_back(folder / (std::to_string(i) + ".jpg"));
  }
  video.write_frames(indices, files, {});
  for (const fs::path& file : files) CHECK(photograph_size(file).width == 64);
}

TEST_CASE("a video that its header turns is written upright") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  const fs::path plain = walled_video(folder, "plain.mp4", kSharpH264), turned = folder / "turned.mp4";
  REQUIRE(run_to_end({find_program("ffmpeg"),
                      {"-y", "-i", plain.string(), "-c", "copy", "-metadata:s:v:0", "rotate=90", turned.string()},
                      folder / "out.txt",
                      folder / "err.txt"}) == 0);
  const VideoFile video(turned, folder / "work");
  const std::vector<std::size_t> indices{2};
  const std::vector<fs::path> files{folder / "a.jpg"};
  video.write_frames(indices, files, {});
  const ImageSize size = photograph_size(files[0]);
  CHECK(size.width == kVideoHeight);
  CHECK(size.height == kVideoWidth);
}

TEST_CASE("frames of another rate, interlaced or in another container come one by one as well") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  // Frames at times that are far from even.
  const VideoFile uneven(
      walled_video(folder, "uneven.mkv",
                   {"-vf", "setpts='N/25/TB+if(gt(N,9),5,0)/TB'", "-vsync", "0", "-c:v", "libx264", "-crf", "8"}),
      folder / "uneven");
  const VideoFile fields(
      walled_video(folder, "fields.avi",
                   {"-vf", "setfield=tff", "-flags", "+ildct+ilme", "-c:v", "mpeg2video", "-q:v", "2"}),
      folder / "fields");
  for (const VideoFile* const video : {&uneven, &fields}) {
    std::size_t frames = 0;
    video->for_each_grey_frame(64, [&](std::span<const std::uint8_t>, std::uint32_t, std::uint32_t) { ++frames; });
    CHECK(frames == kVideoFrames);
  }
}

TEST_CASE("brightness for HDR displays becomes that of ordinary ones") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  const VideoFile video(
      walled_video(
          folder, "hlg.mkv",
          {"-vf", "zscale=tin=bt709:pin=bt709:min=gbr:t=arib-std-b67:p=bt2020:m=bt2020nc:npl=203,format=yuv420p10le",
           "-c:v", "ffv1", "-color_trc", "arib-std-b67", "-color_primaries", "bt2020", "-colorspace", "bt2020nc"}),
      folder / "work");
  CHECK(video.facts().is_hdr);
  const std::vector<std::size_t> indices{5};
  const std::vector<fs::path> files{folder / "a.jpg"};
  video.write_frames(indices, files, {});
  // Only the brightest third is compressed; taken as they are coded, colours would be off by far more.
  CHECK(middle_difference(read_photograph(files[0]), read_photograph(folder / "pictures" / "105.png")) < 12);
}

TEST_CASE("what is no video, or ends early, is told in a sentence") {
  if (!has_ffmpeg()) return;
  const TemporaryFolder folder;
  const fs::path text = folder.with_file("text.mp4", "not a video at all");
  CHECK_THROWS_WITH(VideoFile(text, folder / "work"), Catch::Contains(text.string() + ": cannot be read as a video"));
  CHECK_THROWS_WITH(VideoFile(folder / "none.mp4", folder / "work"), Catch::Contains("No such file"));

  const fs::path whole = walled_video(folder, "whole.mkv", kSharpH264);
  const std::string bytes = read_whole_file(whole);
  const fs::path cut = folder.with_file("cut.mkv", bytes.substr(0, bytes.size() * 4 / 5));
  const VideoFile video(cut, folder / "work");
  std::size_t frames = 0;
  video.for_each_grey_frame(64, [&](std::span<const std::uint8_t>, std::uint32_t, std::uint32_t) { ++frames; });
  CHECK(frames > 0);
  CHECK(frames < kVideoFrames);
  CHECK_FALSE(video.damage().empty());
  const std::vector<std::size_t> indices{0, 500};
  const std::vector<fs::path> files{folder / "a.jpg", folder / "b.jpg"};
  CHECK_THROWS_WITH(video.write_frames(indices, files, {}), Catch::Contains("its frame 500 cannot be written"));
}

TEST_CASE("without FFmpeg one sentence says what to install") {
  const TemporaryFolder folder;
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder.path().c_str(), 1);
  CHECK_THROWS_WITH(VideoFile(folder / "walk.mp4", folder / "work"), Catch::Contains("apt install ffmpeg"));
  setenv("PATH", before.c_str(), 1);
}

TEST_CASE("videos are told by their endings, in any case") {
  CHECK(has_video_ending("a/IMG_1.MOV"));
  CHECK(has_video_ending("walk.mp4"));
  CHECK_FALSE(has_video_ending("walk.jpg"));
  CHECK_FALSE(has_video_ending("mp4"));
}

}  // namespace
}  // namespace lumatlas
