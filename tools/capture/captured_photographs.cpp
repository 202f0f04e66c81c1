// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/captured_photographs.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <utility>

#include "atlas/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "tools/base/interrupt.h"
#include "tools/capture/step_record.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

bool is_photograph(const fs::path& path) {
  constexpr std::array kEndings{".jpg", ".jpeg", ".png", ".tif", ".tiff", ".webp"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

bool is_hidden(const fs::path& path) {
  return path.filename().string().starts_with('.');
}

// What a header says of the lens; a file that cannot be read says nothing, and COLMAP passes over it.
std::string lens_text(const fs::path& path) {
  try {
    const CameraNote note = read_camera_note(path);
    return size_text(note.size.width, note.size.height) + " " + note.make + " " + note.model + " " +
           std::to_string(note.focal_length_mm);
  } catch (const InputError&) {
    return {};
  }
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

}  // namespace

CapturedPhotographs find_photographs(const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) throw InputError(folder.string() + ": no such folder of photographs");
  CapturedPhotographs result{fs::canonical(folder), {}};
  for (auto entry = fs::recursive_directory_iterator(result.folder, error); entry != fs::end(entry);
       entry.increment(error)) {
    if (error) break;
    if (is_hidden(entry->path())) {
      entry.disable_recursion_pending();
    } else if (std::error_code ignored; is_photograph(entry->path()) && entry->is_regular_file(ignored)) {
      result.names.push_back(entry->path().lexically_relative(result.folder).generic_string());
    }
  }
  if (error) throw InputError(folder.string() + ": cannot be read (" + error.message() + ")");
  std::sort(result.names.begin(), result.names.end());
  for (const std::string& name : result.names) require_usable_name(folder, name);
  if (result.names.size() >= 2) return result;
  throw InputError(folder.string() + ": holds " + std::to_string(result.names.size()) +
                   " photographs (.jpg, .png, .tif, .webp), at least two must be there, better twenty that overlap");
}

nlohmann::json states_of(const CapturedPhotographs& photographs) {
  nlohmann::json states = nlohmann::json::object();
  for (const std::string& name : photographs.names) states[name] = file_state(photographs.folder / name);
  return states;
}

std::vector<std::vector<std::string>> names_by_lens(const CapturedPhotographs& photographs) {
  std::map<std::string, std::vector<std::string>> by_lens;
  for (const std::string& name : photographs.names) {
    throw_if_interrupted();
    by_lens[lens_text(photographs.folder / name)].push_back(name);
  }
  std::vector<std::string> unreadable = std::move(by_lens[""]);
  by_lens.erase("");
  std::vector<std::vector<std::string>> lenses;
  for (auto& [lens, names] : by_lens) lenses.push_back(std::move(names));
  std::sort(lenses.begin(), lenses.end(), [](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() > b.size() : a.front() < b.front();
  });
  if (lenses.empty()) lenses.emplace_back();
  std::vector<std::string>& most = lenses.front();
  most.insert(most.end(), unreadable.begin(), unreadable.end());
  std::sort(most.begin(), most.end());
  return lenses;
}

}  // namespace lumatlas
