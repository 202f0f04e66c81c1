// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/sources/captured_photographs.h"

#include <algorithm>
#include <map>
#include <utility>

#include "mesh/base/number_text.h"
#include "tools/capture/step_record.h"

namespace lumatlas {

namespace {

// Returns what tells lenses apart; empty for a photograph that cannot be read.
std::string lens_text(const CapturedPhotograph& photograph) {
  if (!photograph.video.empty()) return "video " + photograph.video;
  const CameraNote& note = photograph.note;
  if (note.size.width == 0) return {};
  return size_text(note.size.width, note.size.height) + " " + note.make + " " + note.model + " " +
         std::to_string(note.focal_length_mm);
}

}  // namespace

std::vector<std::string> names_of(const CapturedPhotographs& captured) {
  std::vector<std::string> names;
  for (const CapturedPhotograph& photograph : captured.photographs) names.push_back(photograph.name);
  return names;
}

nlohmann::json states_of(const CapturedPhotographs& captured) {
  nlohmann::json states = nlohmann::json::object();
  for (const std::string& name : names_of(captured)) states[name] = file_state(captured.folder / name);
  return states;
}

std::vector<std::vector<std::string>> names_by_lens(const CapturedPhotographs& captured) {
  std::map<std::string, std::vector<std::string>> by_lens;
  for (const CapturedPhotograph& photograph : captured.photographs) {
    by_lens[lens_text(photograph)].push_back(photograph.name);
  }
  std::vector<std::string> unreadable = std::move(by_lens[""]);
  by_lens.erase("");
  std::vector<std::vector<std::string>> lenses;
  lenses.reserve(by_lens.size());
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
