// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/sources/prepared_photographs.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tools/base/process/interrupt.h"
#include "tools/capture/sources/video_motion.h"
#include "tools/capture/work_folder.h"
#include "tools/video/frame_choice.h"
#include "tools/video/video_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// The JPEG quality of photographs in other forms: what it loses is below what tells features apart, and below noise.
constexpr int kConvertedQuality = 97;

std::string percent(double share) {
  return std::to_string(std::lround(100 * share)) + " %";
}

CameraNote note_of(const fs::path& file) {
  try {
    return read_camera_note(file);
  } catch (const InputError&) {
    return {};
  }
}

void make_folder_of(const fs::path& file) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw InputError(file.parent_path().string() + ": cannot be made (" + error.message() + ")");
}

void convert(const fs::path& source, const fs::path& made) {
  const Photograph photograph = read_photograph(source);
  CameraNote note = note_of(source);
  const std::vector<std::uint8_t> bytes = encode_image(photograph, {ImageFormat::jpeg, kConvertedQuality}, note);
  make_folder_of(made);
  write_whole_file(made, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  mark_as_made_of(made, source);
}

class Preparation {
 public:
  Preparation(const CaptureSources& sources, const fs::path& work, std::size_t most_frames,
              const PreparationListener& listener)
      : sources_(sources), work_(work), folder_(work / "images"), most_frames_(most_frames), listener_(listener) {
    result_.captured = {sources.given, sources.folder, folder_, {}};
    result_.left_out = sources.left_out;
  }

  PreparedPhotographs run() {
    take_over_earlier_folder();
    make_folder_of(folder_ / "any");
    link_photographs();
    convert_photographs();
    take_frames();
    remove_others();
    for (auto& [name, photograph] : kept_) {
      throw_if_interrupted();
      if (photograph.video.empty()) photograph.note = note_of(folder_ / name);
      result_.captured.photographs.push_back(std::move(photograph));
    }
    return std::move(result_);
  }

 private:
  void say(const std::string& sentence) const {
    if (listener_.say) listener_.say(sentence);
  }

  [[nodiscard]] std::function<void(std::size_t)> stage(const std::string& name, std::size_t steps) const {
    if (steps == 0 || !listener_.stage) return [](std::size_t) { throw_if_interrupted(); };
    return listener_.stage(name, steps);
  }

  void take_over_earlier_folder() const {
    std::error_code ignored;
    if (!fs::is_symlink(folder_, ignored)) return;
    put_link(folder_, {});
    const fs::path earlier = earlier_photographs(work_);
    if (!fs::is_directory(earlier, ignored)) return;
    std::error_code error;
    fs::rename(earlier, folder_, error);
    if (error)
      throw InputError(earlier.string() + ": cannot be moved to " + folder_.string() + " (" + error.message() + ")");
  }

  void keep(const std::string& name, const std::string& video, const std::string& converted) {
    kept_.emplace(name, CapturedPhotograph{name, video, {}, converted});
  }

  void link_photographs() {
    for (const std::string& name : sources_.photographs) {
      throw_if_interrupted();
      make_folder_of(folder_ / name);
      put_link(folder_ / name, sources_.folder / name);
      keep(name, {}, {});
    }
  }

  void convert_photographs() {
    const auto tick = stage("photographs for COLMAP", sources_.converted.size());
    for (const std::string& name : sources_.converted) {
      const std::string made = name_of_converted(name);
      try {
        if (!is_made_of(folder_ / made, sources_.folder / name)) {
          convert(sources_.folder / name, folder_ / made);
          result_.made_anything = true;
        }
        keep(made, {}, name);
        ++result_.converted;
      } catch (const InputError& error) {
        result_.left_out[name] = std::string("cannot be used: ") + error.what();
      }
      tick(1);
    }
    if (result_.converted == 0) return;
    say("  " + std::to_string(result_.converted) + " photographs in other forms are JPEG files for COLMAP now, in " +
        folder_.string());
  }

  [[nodiscard]] fs::path work_of(const std::string& video) const { return work_ / "videos" / video; }

  void take_frames() {
    if (sources_.videos.empty()) return;
    std::vector<VideoFile> videos;
    std::vector<std::vector<VideoFrame>> frames;
    for (const std::string& name : sources_.videos) {
      videos.emplace_back(sources_.folder / name, work_of(name));
      VideoMotion motion =
          motion_of(videos.back(), sources_.folder / name, work_of(name) / "motion.json", listener_.stage);
      result_.videos.push_back(
          {name, motion.frames.size(), 0, videos.back().facts().seconds, std::move(motion.damage)});
      frames.push_back(std::move(motion.frames));
    }
    FrameChoiceOptions options;
    options.step = step_for(frames, most_frames_, options);
    result_.step = options.step;
    std::vector<std::vector<std::size_t>> chosen;
    chosen.reserve(frames.size());
    for (const std::vector<VideoFrame>& of_video : frames) chosen.push_back(choose_frames(of_video, options));
    leave_at_most(chosen, most_frames_);
    for (std::size_t i = 0; i < videos.size(); ++i) {
      result_.videos[i].taken = chosen[i].size();
      write_chosen(videos[i], sources_.videos[i], chosen[i]);
      tell_of(result_.videos[i]);
    }
    tell_of_step();
  }

  // The number of a frame in its name has as many digits for each frame of the video.
  static std::string frame_name(const std::string& video, std::size_t index) {
    constexpr std::size_t kDigits = 6;
    std::string digits = std::to_string(index);
    digits.insert(0, kDigits - std::min(kDigits, digits.size()), '0');
    return video + "/" + digits + ".jpg";
  }

  void write_chosen(const VideoFile& video, const std::string& name, const std::vector<std::size_t>& chosen) {
    std::vector<std::size_t> missing;
    std::vector<fs::path> files;
    for (const std::size_t index : chosen) {
      const std::string frame = frame_name(name, index);
      keep(frame, name, {});
      if (is_made_of(folder_ / frame, sources_.folder / name)) continue;
      missing.push_back(index);
      files.push_back(folder_ / frame);
    }
    if (missing.empty()) return;
    make_folder_of(files.front());
    const auto tick = stage("photographs of " + fs::path(name).filename().string(), missing.size());
    std::size_t told = 0;
    video.write_frames(missing, files, [&](std::size_t written) {
      if (written > told) tick(written - told);
      told = std::max(told, written);
    });
    for (const fs::path& file : files) mark_as_made_of(file, sources_.folder / name);
    result_.made_anything = true;
  }

  void tell_of(const CapturedVideo& video) const {
    std::string sentence = "  " + video.name + ": " + std::to_string(video.taken) + " of " +
                           std::to_string(video.frames) + " frames are taken, the sharpest wherever the picture has " +
                           "moved by about " + percent(result_.step) + " of its longer side";
    if (video.taken == 1) sentence += "; the camera hardly moves in it";
    if (!video.damage.empty()) sentence += "; it is damaged (ffmpeg says '" + video.damage + "')";
    say(sentence);
  }

  void tell_of_step() const {
    const double usual = FrameChoiceOptions().step;
    if (result_.step <= usual) return;
    std::string sentence = "  a step of " + percent(usual) + " would take more than " + std::to_string(most_frames_) +
                           " frames (--max-frames)";
    if (result_.step > kLargestGoodStep) sentence += "; frames that overlap so little may not find their places";
    say(sentence);
  }

  // Removes what the folder holds of photographs that have gone and frames that are not chosen any more.
  void remove_others() const {
    std::vector<fs::path> others;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const bool is_folder = entry.is_directory() && !entry.is_symlink();
      const std::string name = entry.path().lexically_relative(folder_).generic_string();
      if (!is_folder && !kept_.contains(name)) others.push_back(entry.path());
    }
    for (const fs::path& other : others) remove_all_of(other);
  }

  const CaptureSources& sources_;
  const fs::path& work_;
  fs::path folder_;
  std::size_t most_frames_;
  const PreparationListener& listener_;
  std::map<std::string, CapturedPhotograph> kept_;  // for each name
  PreparedPhotographs result_;
};

}  // namespace

bool need_preparation(const CaptureSources& sources) {
  return !sources.converted.empty() || !sources.videos.empty();
}

PreparedPhotographs prepare_photographs(const CaptureSources& sources, const fs::path& work, std::size_t most_frames,
                                        const PreparationListener& listener) {
  PreparedPhotographs prepared = Preparation(sources, work, most_frames, listener).run();
  if (prepared.captured.photographs.size() >= 2) return prepared;
  const std::string why = prepared.left_out.empty()
                              ? ": the camera must move, and show what has texture"
                              : ": " + prepared.left_out.begin()->first + " " + prepared.left_out.begin()->second;
  throw InputError(sources.folder.string() + ": gives " + std::to_string(prepared.captured.photographs.size()) +
                   " photographs, at least two must be there" + why);
}

fs::path earlier_photographs(const fs::path& work) {
  return work / "photographs";
}

}  // namespace lumatlas
