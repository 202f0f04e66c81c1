// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/video/video_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/file_ending.h"
#include "tools/base/process/child_process.h"
#include "tools/base/strict_json.h"
#include "tools/video/grey_stream.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Turns fields into frames, and pixels that are not square into ones that are. ffmpeg turns the frames upright itself.
constexpr const char* kWholeFrames = "bwdif=mode=send_frame:deint=interlaced,scale=iw*sar:ih,setsar=1";
// Numbers the frames by time, so that each one that comes is written once, whatever its time was.
constexpr const char* kOneByOne = "settb=1/25,setpts=N";

// The filter that shows brightness coded by PQ or HLG on a display of the ordinary range, the same for every frame: up
// to a third of the white of ITU-R BT.2408 (203 cd/m2) unchanged, above that compressed.
constexpr const char* kOrdinaryRange =
    "zscale=t=linear:npl=203,format=gbrpf32le,zscale=p=bt709,tonemap=tonemap=mobius:desat=0,"
    "zscale=t=bt709:m=bt709:r=tv,format=yuv420p";

fs::path find_program_of_ffmpeg(const char* name) {
  if (fs::path program = find_program(name); !program.empty()) return program;
  throw InputError(std::string(name) +
                   ": no such program in PATH, and videos are read by it: install FFmpeg (on Debian "
                   "`apt install ffmpeg`), or give photographs instead");
}

// A name could begin with what ffmpeg takes for an option or a protocol.
std::string input_name(const fs::path& file) {
  return "file:" + fs::absolute(file).string();
}

// Returns an empty line where the file is missing or empty.
std::string first_line(const fs::path& file) {
  std::ifstream text(file);
  std::string line;
  std::getline(text, line);
  return line;
}

// Returns the number of "30000/1001", "12.5" or "250"; 0 where the text is none.
double number_of(const json& object, const char* key) {
  const json value = object.value(key, json());
  if (value.is_number()) return value.get<double>();
  if (!value.is_string()) return 0;
  const auto& text = value.get_ref<const std::string&>();
  std::array<double, 2> parts{0, 1};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (double& part : parts) {
    const auto [next, error] = std::from_chars(at, end, part);
    if (error != std::errc()) return 0;
    at = next;
    if (at == end || *at++ != '/') break;
  }
  const double number = parts[1] == 0 ? 0 : parts[0] / parts[1];
  return number > 0 ? number : 0;
}

// For ffmpeg's names of numbered files, in which '%' begins a number.
std::string pattern_in(const fs::path& folder) {
  std::string pattern;
  for (const char c : folder.string()) pattern += c == '%' ? std::string("%%") : std::string(1, c);
  return pattern + "/%08d.jpg";
}

fs::path numbered_file(const fs::path& folder, std::size_t number) {
  std::string digits = std::to_string(number);
  digits.insert(0, 8 - std::min<std::size_t>(8, digits.size()), '0');
  return folder / (digits + ".jpg");
}

// An empty folder that goes with this object.
class EmptyFolder {
 public:
  explicit EmptyFolder(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    fs::remove_all(path_, error);
    fs::create_directories(path_, error);
    if (error) throw InputError(path_.string() + ": cannot be made (" + error.message() + ")");
  }
  ~EmptyFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  EmptyFolder(const EmptyFolder&) = delete;
  EmptyFolder& operator=(const EmptyFolder&) = delete;

  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// An expression of ffmpeg that is not 0 for these frames. It is nested as a balanced tree, for ffmpeg refuses a sum of
// more than a hundred terms.
std::string any_of_frames(std::span<const std::size_t> indices) {
  if (indices.size() == 1) return "eq(n," + std::to_string(indices[0]) + ")";
  const std::size_t half = indices.size() / 2;
  return "(" + any_of_frames(indices.first(half)) + "+" + any_of_frames(indices.subspan(half)) + ")";
}

}  // namespace

bool has_video_ending(const fs::path& file) {
  constexpr std::array kEndings{".mp4", ".mov",  ".m4v", ".mkv",  ".webm", ".avi", ".mts",
                                ".mpg", ".m2ts", ".3gp", ".mpeg", ".wmv",  ".ogv"};
  return std::find(kEndings.begin(), kEndings.end(), lower_case_ending(file)) != kEndings.end();
}

VideoFile::VideoFile(fs::path file, fs::path work)
    : file_(std::move(file)), work_(std::move(work)), ffmpeg_(find_program_of_ffmpeg("ffmpeg")) {
  std::error_code error;
  fs::create_directories(work_, error);
  if (error) throw InputError(work_.string() + ": cannot be made (" + error.message() + ")");
  probe();
}

void VideoFile::probe() {
  const fs::path program = find_program_of_ffmpeg("ffprobe"), out = work_ / "ffprobe.json", err = work_ / "ffprobe.txt";
  const int status = run_to_end(
      {program,
       {"-v", "error", "-protocol_whitelist", "file", "-select_streams", "v:0", "-show_entries",
        "stream=avg_frame_rate,nb_frames,duration,color_transfer:format=duration", "-of", "json", input_name(file_)},
       out,
       err});
  const json said = status == 0 ? read_json(out) : json();
  const json streams = said.is_object() ? said.value("streams", json::array()) : json::array();
  if (!streams.is_array() || streams.empty() || !streams[0].is_object()) {
    const std::string reason = first_line(err);
    throw InputError(file_.string() + ": cannot be read as a video" +
                     (reason.empty() ? ": FFmpeg finds no pictures in it" : ", FFmpeg says '" + reason + "'"));
  }
  const json format = said.value("format", json::object());
  facts_.frames_per_second = number_of(streams[0], "avg_frame_rate");
  facts_.seconds = number_of(streams[0], "duration");
  if (facts_.seconds == 0) facts_.seconds = number_of(format, "duration");
  constexpr double kMostFrames = 1e9;
  double frames = number_of(streams[0], "nb_frames");
  if (frames == 0) frames = facts_.seconds * facts_.frames_per_second;
  facts_.frames = static_cast<std::uint64_t>(std::min(frames, kMostFrames));
  const json transfer = streams[0].value("color_transfer", json());
  facts_.is_hdr = transfer == "smpte2084" || transfer == "arib-std-b67";
}

int VideoFile::run_ffmpeg(const std::vector<std::string>& arguments, const fs::path& out,
                          const std::function<void()>& while_waiting) const {
  std::vector<std::string> all{"-hide_banner",        "-nostdin",  "-loglevel", "error",          "-y", "-an", "-sn",
                               "-protocol_whitelist", "file,pipe", "-i",        input_name(file_)};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return run_to_end({ffmpeg_, all, out, words()}, while_waiting);
}

std::string VideoFile::reason(int status) const {
  const std::string said = damage();
  return (status < 0 ? ", ffmpeg was ended by signal " + std::to_string(-status) : "") +
         (said.empty() ? "" : ", ffmpeg says '" + said + "'") + ": see " + words().string();
}

void VideoFile::for_each_grey_frame(std::uint32_t longer_px, const Look& look) const {
  const std::string box = std::to_string(longer_px);
  const std::string filters = std::string(kWholeFrames) + ",scale=w='min(" + box + ",iw)':h='min(" + box +
                              ",ih)':force_original_aspect_ratio=decrease,format=gray," + kOneByOne;
  GreyStream stream(work_ / "frames", look);
  const int status =
      run_ffmpeg({"-map", "0:v:0", "-vf", filters, "-r", "25", "-c:v", "pgm", "-f", "image2pipe", "pipe:1"},
                 stream.path(), [&] { stream.read(); });
  stream.read();  // the rest
  // ffmpeg fails at the end of a video that is cut off.
  if (status < 0 || stream.frames() == 0) throw InputError(file_.string() + ": no frames can be read" + reason(status));
}

void VideoFile::write_frames(std::span<const std::size_t> indices, std::span<const fs::path> files,
                             const std::function<void(std::size_t)>& tick) const {
  if (indices.empty()) return;
  const EmptyFolder folder(work_ / "chosen");
  const std::string filters = std::string(kWholeFrames) + "," + "select='" + any_of_frames(indices) + "'," +
                              (facts_.is_hdr ? std::string(kOrdinaryRange) + "," : "") +
                              "scale=out_color_matrix=bt601:out_range=full,format=yuvj444p," + kOneByOne;
  std::size_t written = 0;
  const int status =
      run_ffmpeg({"-map", "0:v:0", "-vf", filters, "-r", "25", "-c:v", "mjpeg", "-qmin", "1", "-q:v", "1", "-f",
                  "image2", "-start_number", "0", pattern_in(folder.path())},
                 "/dev/null", [&] {
                   std::error_code ignored;
                   while (written < indices.size() && fs::exists(numbered_file(folder.path(), written), ignored))
                     ++written;
                   if (tick) tick(written);
                 });
  for (std::size_t i = 0; i < indices.size(); ++i) {
    std::error_code error;
    fs::rename(numbered_file(folder.path(), i), files[i], error);
    if (error) {
      throw InputError(file_.string() + ": its frame " + std::to_string(indices[i]) + " cannot be written to " +
                       files[i].string() + " (" + error.message() + ")" + reason(status));
    }
  }
  if (tick) tick(indices.size());
}

std::string VideoFile::damage() const {
  return first_line(words());
}

}  // namespace lumatlas
