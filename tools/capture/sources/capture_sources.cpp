// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/sources/capture_sources.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <span>
#include <string_view>

#include "mesh/base/errors.h"
#include "mesh/base/file_ending.h"
#include "tools/base/files_below.h"
#include "tools/capture/step_record.h"
#include "tools/capture/work_folder.h"
#include "tools/video/video_file.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::array kAsTheyAre{".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
constexpr std::array kConverted{".heic", ".heif", ".hif", ".avif", ".dng", ".cr2",
                                ".cr3",  ".nef",  ".arw", ".raf",  ".orf", ".rw2"};
struct UnreadForm {
  const char* ending;
  const char* name;  // with its article
};
constexpr std::array kNotRead{UnreadForm{".bmp", "a BMP picture"},       UnreadForm{".exr", "an OpenEXR picture"},
                              UnreadForm{".gif", "a GIF picture"},       UnreadForm{".insp", "an Insta360 photograph"},
                              UnreadForm{".insv", "an Insta360 video"},  UnreadForm{".j2k", "a JPEG 2000 picture"},
                              UnreadForm{".jp2", "a JPEG 2000 picture"}, UnreadForm{".jpx", "a JPEG 2000 picture"},
                              UnreadForm{".jxl", "a JPEG XL picture"},   UnreadForm{".ppm", "a PPM picture"},
                              UnreadForm{".psd", "a Photoshop picture"}, UnreadForm{".tga", "a TGA picture"}};

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool ends_as_one_of(std::span<const char* const> endings, const fs::path& path) {
  return std::find(endings.begin(), endings.end(), lower_case_ending(path)) != endings.end();
}

// Null for a file of any other form.
const UnreadForm* unread_form_of(const fs::path& path) {
  const std::string ending = lower_case_ending(path);
  const auto* const found =
      std::find_if(kNotRead.begin(), kNotRead.end(), [&](const UnreadForm& form) { return form.ending == ending; });
  return found == kNotRead.end() ? nullptr : found;
}

// The name without its ending, in lower case.
std::string stem_of(const std::string& name) {
  return lower(fs::path(name).replace_extension().generic_string());
}

// COLMAP reads its list of photographs line by line, without the blanks around a name. The model that comes of them
// holds names in JSON.
void require_usable_name(const fs::path& folder, const std::string& name) {
  const std::string place = (folder / name).string();
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (std::any_of(name.begin(), name.end(), is_control) || name.front() == ' ') {
    throw InputError(place +
                     ": its name holds a line break or begins with a blank, which COLMAP's list of photographs " +
                     "cannot hold: rename it");
  }
  if (!is_utf8(name)) throw InputError(place + ": its name is not UTF-8, which a model needs: rename the photograph");
}

// Files of the kernel say that they have no bytes too, and reading some of them never ends.
bool is_empty_file(const fs::path& file) {
  std::error_code error;
  return fs::file_size(file, error) == 0 && !error;
}

void take(const std::string& name, CaptureSources& sources) {
  const bool is_source = ends_as_one_of(kAsTheyAre, name) || ends_as_one_of(kConverted, name) || has_video_ending(name);
  if (is_source && is_empty_file(sources.folder / name)) {
    sources.left_out[name] = "is empty";
  } else if (ends_as_one_of(kAsTheyAre, name)) {
    sources.photographs.push_back(name);
  } else if (ends_as_one_of(kConverted, name)) {
    sources.converted.push_back(name);
  } else if (has_video_ending(name)) {
    sources.videos.push_back(name);
  } else if (const UnreadForm* const form = unread_form_of(name)) {
    sources.left_out[name] = std::string("is ") + form->name + ", which capture does not read: save it as " +
                             (std::string_view(form->ending) == ".insv" ? "MP4" : "JPEG or PNG");
  }
}

void look_through(const fs::path& given, const fs::path& masks, CaptureSources& sources) {
  const FilesBelow files = files_below(sources.folder, [&](const fs::path& path) {
    std::error_code ignored;
    return path.filename().string().starts_with('.') || (!masks.empty() && fs::equivalent(path, masks, ignored));
  });
  if (files.error) throw InputError(given.string() + ": cannot be read (" + files.error.message() + ")");
  for (const std::string& name : files.names) take(name, sources);
}

// Moves the names of a list whose stem is in `stems` to those that are left out.
void leave_out_known(std::vector<std::string>& names, const std::map<std::string, std::string>& stems, const char* why,
                     CaptureSources& sources) {
  std::erase_if(names, [&](const std::string& name) {
    const auto known = stems.find(stem_of(name));
    if (known == stems.end()) return false;
    sources.left_out[name] = why + fs::path(known->second).filename().string() + " beside it";
    return true;
  });
}

// A converted photograph NAME becomes NAME.jpg: a photograph of that name was most likely made of it before.
void leave_out_converted_before(CaptureSources& sources) {
  const std::vector<std::string>& known = sources.photographs;
  std::erase_if(sources.converted, [&](const std::string& name) {
    const std::string made = name_of_converted(name);
    if (std::find(known.begin(), known.end(), made) == known.end()) return false;
    sources.left_out[name] = "is taken to show the same as " + fs::path(made).filename().string() + " beside it";
    return true;
  });
}

void leave_out_twins(CaptureSources& sources) {
  leave_out_converted_before(sources);
  std::map<std::string, std::string> stems;
  for (const std::string& name : sources.photographs) stems.emplace(stem_of(name), name);
  leave_out_known(sources.converted, stems, "is taken to show the same as ", sources);
  for (const std::string& name : sources.converted) stems.emplace(stem_of(name), name);
  leave_out_known(sources.videos, stems, "is taken to be the moving part of the photograph ", sources);
}

}  // namespace

std::string name_of_converted(const std::string& name) {
  return name + ".jpg";
}

CaptureSources find_sources(const fs::path& given, const fs::path& masks) {
  std::error_code error;
  CaptureSources sources;
  sources.given = given;
  if (fs::is_regular_file(given, error) && has_video_ending(given)) {
    if (is_empty_file(given)) throw InputError(given.string() + ": is empty");
    sources.folder = fs::canonical(fs::absolute(given).parent_path());
    sources.videos.push_back(given.filename().string());
  } else if (fs::is_directory(given, error)) {
    sources.folder = fs::canonical(given);
    look_through(given, masks, sources);
  } else {
    throw InputError(given.string() + (fs::exists(given, error) ? ": is neither a folder of photographs nor a video"
                                                                : ": no such folder of photographs or video"));
  }
  for (std::vector<std::string>* const names : {&sources.photographs, &sources.converted, &sources.videos}) {
    std::sort(names->begin(), names->end());
    for (const std::string& name : *names) require_usable_name(sources.folder, name);
  }
  leave_out_twins(sources);
  const std::size_t photographs = sources.photographs.size() + sources.converted.size();
  if (!sources.videos.empty() || photographs >= 2) return sources;
  const std::string first_left_out =
      sources.left_out.empty() ? "" : "; " + sources.left_out.begin()->first + " " + sources.left_out.begin()->second;
  throw InputError(given.string() + ": holds " + std::to_string(photographs) +
                   " photographs (.jpg, .png, .tif, .webp, .heic, .avif or a camera's raw form) and no video, at least "
                   "two must be there, better twenty that overlap" +
                   first_left_out);
}

}  // namespace lumatlas
