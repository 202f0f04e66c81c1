// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/growing_scene.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/scene/scene_notes.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

bool same_pose(const Camera& a, const Camera& b) {
  return a.cam_from_world_rotation == b.cam_from_world_rotation &&
         a.cam_from_world_translation == b.cam_from_world_translation;
}

constexpr const char* kBeingWritten = ": is still being written";

}  // namespace

GrowingScene::GrowingScene(fs::path scene, const glm::dvec3& offset, PictureFolders folders)
    : scene_(std::move(scene)), offset_(offset), folders_(std::move(folders)) {}

// Returns the states of the files that are there.
std::vector<GrowingScene::FileState> GrowingScene::states_of(const std::vector<fs::path>& files) {
  std::vector<FileState> states;
  for (const fs::path& file : files) {
    std::error_code missing, no_size;
    const fs::file_time_type time = fs::last_write_time(file, missing);
    if (missing) continue;
    const std::uintmax_t size = fs::file_size(file, no_size);  // a folder has none
    states.push_back({file, no_size ? 0 : size, time});
  }
  return states;
}

GrowingScene::News GrowingScene::look() {
  News news;
  read_list(news);
  for (const ListedView& listed : listed_) look_at(listed, candidates_[listed.view.name], news);
  return news;
}

void GrowingScene::read_list(News& news) {
  std::vector<FileState> files = states_of(files_of_list(scene_));
  if (files != list_files_) {
    list_files_ = std::move(files);
    list_rested_ = 0;
    list_error_named_ = false;
    news.changed = true;
    return;
  }
  ++list_rested_;
  // Only COLMAP's list is in these files alone: the others go by what photographs are there.
  if (read_files_ == list_files_ && form_ == "COLMAP") return;
  try {
    SceneList list = list_scene_views(scene_, offset_, folders_);
    if (states_of(files_of_list(scene_)) != list_files_) return;  // it was written meanwhile
    list_error_.clear();
    accept(std::move(list), news);
  } catch (const InputError& error) {
    list_error_ = error.what();
    if (list_rested_ < kPatience || list_error_named_) return;
    news.warnings.push_back(
        list_error_ + (listed_.empty() ? "; waiting for it" : "; the photographs that it listed before are kept"));
    list_error_named_ = true;
  }
}

void GrowingScene::accept(SceneList list, News& news) {
  listed_ = std::move(list.views);
  notes_ = std::move(list.notes);
  georeference_ = std::move(list.georeference);
  left_out_ = list.left_out;
  form_ = std::move(list.form);
  read_files_ = list_files_;
  if (moves_named_) return;
  std::size_t moved = 0;
  for (const ListedView& listed : listed_) {
    const auto known = candidates_.find(listed.view.name);
    if (known == candidates_.end() || !known->second.given) continue;
    if (!same_pose(known->second.given->camera, listed.view.camera)) ++moved;
  }
  if (moved == 0) return;
  moves_named_ = true;
  news.warnings.push_back(scene_.string() + ": " + std::to_string(moved) +
                          " photographs that are in use have other poses now, which are not taken: build again once "
                          "all are there");
}

void GrowingScene::look_at(const ListedView& listed, Candidate& candidate, News& news) const {
  if (candidate.given) return;
  SceneView view = listed.view;
  if (!view.mask) view.mask = mask_of(view, mask_folder(scene_, folders_));
  std::vector<FileState> files = states_of({view.image});
  if (!files.empty() && view.mask) {
    const std::vector<FileState> mask = states_of({*view.mask});
    files.insert(files.end(), mask.begin(), mask.end());
  }
  if (files != candidate.files) {
    candidate.files = std::move(files);
    candidate.rested = 0;
    candidate.bad.clear();
    news.changed = true;
    return;
  }
  if (files.empty()) return;
  ++candidate.rested;
  if (!candidate.bad.empty() && candidate.rested != kPatience) return;
  try {
    ListedView fitted = listed;
    fit_to_photograph(fitted);
    fitted.view.mask = view.mask;
    view = std::move(fitted.view);
    if (candidate.rested == kPatience && !candidate.bad.empty()) (void)load_photograph(view);
    candidate.given = view;
    candidate.bad.clear();
    news.ready.push_back(std::move(view));
  } catch (const InputError& error) {
    candidate.bad = error.what();
    if (candidate.rested < kPatience || candidate.named) return;
    candidate.named = true;
    news.warnings.push_back(candidate.bad);
  }
}

std::vector<std::string> GrowingScene::notes(const std::vector<SceneView>& used) const {
  SceneViews scene{scene_, used};
  scene.notes = notes_;
  if (!used.empty()) note_masks(mask_folder(scene_, folders_), scene);
  scene.views.clear();  // a listed view that did not come has a pose all the same
  for (const ListedView& listed : listed_) scene.views.push_back(listed.view);
  note_unposed(left_out_, scene);
  return std::move(scene.notes);
}

void GrowingScene::give_back(const SceneView& view, const std::string& why) {
  Candidate& candidate = candidates_[view.name];
  candidate.given.reset();
  candidate.bad = why;
}

GrowingScene::Missing GrowingScene::missing() const {
  Missing missing;
  for (const ListedView& listed : listed_) {
    const auto found = candidates_.find(listed.view.name);
    if (found != candidates_.end() && found->second.given) continue;
    if (found == candidates_.end() || found->second.files.empty()) {
      if (missing.absent++ == 0) missing.first_absent = listed.view.name;
      continue;
    }
    SceneView& view = missing.bad.emplace_back(listed.view);
    view.bad = found->second.bad.empty() ? view.image.string() + kBeingWritten : found->second.bad;
    if (!found->second.named) missing.warnings.push_back(view.bad);
  }
  return missing;
}

}  // namespace lumatlas
