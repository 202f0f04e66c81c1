// SPDX-License-Identifier: GPL-3.0-or-later
// Files by name and number, and videos through programs that stand in for ffmpeg.
#include "tools/picture/picture_output.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

Photograph frame(std::uint32_t width, std::uint32_t height, std::uint8_t level) {
  Photograph picture;
  picture.width = width;
  picture.height = height;
  picture.rgb.assign(std::size_t{3} * width * height, level);
  return picture;
}

// A folder on PATH, before all others or alone, with a program `ffmpeg` that is this shell script.
class FakeFfmpeg {
 public:
  explicit FakeFfmpeg(const std::string& script, bool alone = false) {
    if (!script.empty()) {
      const fs::path program = folder_.with_file("ffmpeg", "#!/bin/sh\n" + script);
      fs::permissions(program, fs::perms::owner_all);
    }
    setenv("PATH", (folder_.path().string() + (alone ? "" : ":" + path_)).c_str(), 1);
  }
  ~FakeFfmpeg() { setenv("PATH", path_.c_str(), 1); }
  FakeFfmpeg(const FakeFfmpeg&) = delete;
  FakeFfmpeg& operator=(const FakeFfmpeg&) = delete;

  [[nodiscard]] fs::path operator/(std::string_view name) const { return folder_ / name; }

 private:
  TemporaryFolder folder_;
  std::string path_ = std::getenv("PATH");
};

// Writes the frames to the file of its last argument, and its arguments beside it.
const std::string kCopies = R"(for last; do :; done; last=${last#file:}
echo "$@" > "$last.arguments"; exec cat > "$last")";

TEST_CASE("frames are numbered with as many digits as the last one needs, views are called as in the scene") {
  PictureOutput png("out", PictureFormat::png, 30);
  CHECK(png.file_for_frame(7, 120) == "00007.png");
  CHECK(png.file_for_frame(7, 1000000) == "000007.png");
  CHECK(png.file_for_frame(0, 1) == "00000.png");
  CHECK(png.file_for_view("a/b.jpg") == "a/b.png");
  CHECK(png.file_for_view("a/b.tif") == "a/b.tif.png");
  PictureOutput exr("out", PictureFormat::exr, 30);
  CHECK(exr.file_for_frame(12, 13) == "00012.exr");
  CHECK(exr.file_for_view("x.jpg") == "x.exr");
}

TEST_CASE("every view gets a picture that can be written, whatever the views are called") {
  const std::string longest(255, 'x');
  std::string umlauts = "a";
  while (umlauts.size() < 255) umlauts += "\xc3\xa4";
  const std::vector<std::string> names{"a.jpg",
                                       "a.png/c.jpg",
                                       "a.png/c.tif",
                                       "b.png/c.jpg",
                                       "b.jpg",
                                       "b.png",
                                       longest,
                                       "d/" + longest,
                                       longest + "/e.jpg",
                                       std::string(251, 'y') + ".jpg",
                                       std::string(251, 'y') + ".tif",
                                       umlauts};
  const TemporaryFolder folder;
  PictureOutput output(folder.path(), PictureFormat::png, 30);
  std::vector<fs::path> files;
  for (const std::string& name : names) files.push_back(output.file_for_view(name));
  for (const fs::path& file : files) {
    CAPTURE(file);
    CHECK_FALSE(fs::exists(folder.path() / file));
    CHECK_NOTHROW(output.write(file, SoftPicture{frame(2, 2, 7), {}}));
    CHECK(fs::is_regular_file(folder.path() / file));
  }
  CHECK(files[0] == "a.png");
  CHECK(files[1] == "a.png_c.jpg-1.png");
  CHECK(files[9] == std::string(251, 'y') + ".png");
  CHECK(files[11].string().size() < 255);
}

TEST_CASE("a video's frames arrive at ffmpeg, every byte and in order, with their size and rate") {
  const FakeFfmpeg ffmpeg(kCopies);
  const TemporaryFolder folder;
  PictureOutput output(folder.path(), PictureFormat::mp4, 23.976);
  constexpr std::uint32_t kWidth = 333;  // odd, and frames larger than a socket's buffer
  constexpr std::uint32_t kHeight = 251;
  for (std::uint8_t level = 0; level < 4; ++level)
    output.write("ignored", SoftPicture{frame(kWidth, kHeight, level), {}});
  output.finish();
  const std::string bytes = bytes_of(folder / "video.mp4");
  REQUIRE(bytes.size() == 4 * 3 * kWidth * kHeight);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    REQUIRE(static_cast<std::size_t>(bytes[i]) == i / (std::size_t{3} * kWidth * kHeight));
  }
  const std::string arguments = bytes_of(folder / "video.mp4.arguments");
  CHECK_THAT(arguments, Catch::Contains("-video_size 333x251 -framerate 23.976 -i pipe:0"));
}

TEST_CASE("without ffmpeg a video is refused at once, with what to do") {
  const FakeFfmpeg none("", true);
  CHECK_THROWS_WITH(
      PictureOutput("out", PictureFormat::mp4, 30),
      "ffmpeg: PATH has no such program, which videos need: install it, or write pictures (--format png)");
  CHECK_NOTHROW(PictureOutput("out", PictureFormat::png, 30));
}

TEST_CASE("an ffmpeg that fails is quoted with its last words, at whatever moment it does") {
  const TemporaryFolder folder;
  const auto sentence = [&](const std::string& script, int frames) -> std::string {
    const FakeFfmpeg ffmpeg(script);
    PictureOutput output(folder.path(), PictureFormat::mp4, 30);
    try {
      for (int i = 0; i < frames; ++i) output.write("", SoftPicture{frame(400, 300, 1), {}});
      output.finish();
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const std::string file = (folder / "video.mp4").string();
  const std::string unknown = "echo first >&2; echo \"Unknown encoder 'libx264'\" >&2; exit 1";
  CHECK(sentence(unknown, 50) == file + ": ffmpeg takes no more frames (Unknown encoder 'libx264')");
  CHECK(sentence("cat > /dev/null; echo 'No space left on device' >&2; exit 3", 2) ==
        file + ": ffmpeg has failed with exit status 3 (No space left on device)");
  CHECK(sentence("cat > /dev/null; kill -9 $$", 2) == file + ": ffmpeg was ended by signal 9");
  CHECK(sentence("cat > /dev/null", 2) == file + ": ffmpeg has written no file");
  CHECK(sentence(kCopies, 2) == "accepted");
}

TEST_CASE("a video that is given up stops ffmpeg, and does not wait for what it is doing") {
  const FakeFfmpeg ffmpeg("exec sleep 1000");
  const TemporaryFolder folder;
  {
    PictureOutput output(folder.path(), PictureFormat::mp4, 30);
    output.write("", SoftPicture{frame(4, 4, 1), {}});
  }
  CHECK_FALSE(fs::exists(folder / "video.mp4"));
}

TEST_CASE("views of different sizes make no video") {
  const FakeFfmpeg ffmpeg(kCopies);
  const TemporaryFolder folder;
  PictureOutput output(folder.path(), PictureFormat::mp4, 30);
  output.write("", SoftPicture{frame(8, 6, 1), {}});
  CHECK_THROWS_WITH(output.write("", SoftPicture{frame(6, 8, 1), {}}),
                    Catch::Contains("8x6 and 6x8") && Catch::Contains("--format png"));
  CHECK_THROWS_WITH(FfmpegPipe("/nowhere/ffmpeg", folder / "v.mp4", 4, 4, 30), Catch::Contains("cannot be started"));
  CHECK_THROWS_WITH(FfmpegPipe("x", folder / "v.mp4", 0, 4, 30), Catch::Contains("at least 1x1"));
  CHECK_THROWS_WITH(FfmpegPipe("x", folder / "v.mp4", 4, 4, 0), Catch::Contains("frames_per_second is 0"));
}

}  // namespace
}  // namespace lumatlas
