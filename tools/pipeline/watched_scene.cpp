// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/watched_scene.h"

#include <algorithm>
#include <iterator>
#include <thread>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

constexpr std::chrono::milliseconds kNap{20};  // longest wait before looking for a request to end

}  // namespace

WatchedScene::WatchedScene(const std::filesystem::path& scene, const glm::dvec3& offset, const PictureFolders& folders,
                           const WatchOptions& options)
    : root_(scene), scene_(scene, offset, folders), options_(options) {}

void WatchedScene::warn(const std::vector<std::string>& warnings) const {
  if (!options_.warn) return;
  for (const std::string& sentence : warnings) options_.warn(sentence);
}

void WatchedScene::look() {
  GrowingScene::News news = scene_.look();
  last_look_ = Clock::now();
  if (news.changed || !news.ready.empty()) last_change_ = *last_look_;
  std::move(news.ready.begin(), news.ready.end(), std::back_inserter(ready_));
  warn(news.warnings);
}

// False: the stream has ended before.
bool WatchedScene::wait_for_one() {
  if (ready_.empty()) last_change_ = Clock::now();  // the caller's work meanwhile took time
  for (;; std::this_thread::sleep_for(std::min(kNap, options_.interval))) {
    throw_if_interrupted();
    if (options_.end && options_.end()) return false;
    if (!ready_.empty()) return true;
    if (!last_look_ || Clock::now() - *last_look_ >= options_.interval) look();
    if (ready_.empty() && options_.idle && Clock::now() - last_change_ >= *options_.idle) return false;
  }
}

SceneViews WatchedScene::first_views() {
  if (!wait_for_one()) {
    throw InputError(root_.string() + ": no photograph of the scene has come" +
                     (scene_.list_error().empty() ? "" : " (" + scene_.list_error() + ")"));
  }
  SceneViews views{root_, {}};
  for (const ListedView& listed : scene_.listed()) views.views.push_back(listed.view);
  views.georeference = scene_.georeference();
  return views;
}

std::optional<SceneView> WatchedScene::next() {
  if (!wait_for_one()) return std::nullopt;
  SceneView view = std::move(ready_.front());
  ready_.pop_front();
  return view;
}

std::vector<SceneView> WatchedScene::left_out() {
  GrowingScene::Missing missing = scene_.missing();
  if (missing.absent > 0) {
    missing.warnings.push_back(root_.string() + ": of " + std::to_string(listed()) + " photographs that it lists " +
                               std::to_string(missing.absent) + " have not come, the first is " + missing.first_absent);
  }
  if (!ready_.empty()) {
    missing.warnings.push_back(root_.string() + ": " + std::to_string(ready_.size()) +
                               " photographs were there at the end and are not used, the first is " +
                               ready_.front().name);
  }
  if (!scene_.list_error().empty()) missing.warnings.push_back(scene_.list_error());
  warn(missing.warnings);
  return std::move(missing.bad);
}

}  // namespace lumatlas
