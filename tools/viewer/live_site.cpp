// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/live_site.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "atlas/model/content_digest.h"
#include "blend/blend_options.h"
#include "blend/tables/fade_zone_shares.h"

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;

SiteFile json_file(const std::string& name, const nlohmann::json& value) {
  const std::string text = value.dump();
  return {name, "application/json", {text.begin(), text.end()}, {}};
}

bool holds_view(const Snapshot& snapshot) {
  return std::any_of(snapshot.views.begin(), snapshot.views.end(), [](const auto& view) { return view != nullptr; });
}

class Stopped : public std::exception {};

// Shows what its source returns, on a thread of its own.
class LivePublisher {
 public:
  LivePublisher(LiveSite& site, SnapshotSource source, ShowingShare share,
                std::function<void(const std::string&)> failed)
      : site_(site), source_(std::move(source)), share_(share), failed_(std::move(failed)), thread_([this] {
          run();
        }) {}
  ~LivePublisher() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    stopped_.notify_all();
    thread_.join();
  }
  LivePublisher(const LivePublisher&) = delete;
  LivePublisher& operator=(const LivePublisher&) = delete;

 private:
  void run() {
    const bool is_much = share_ == ShowingShare::much;
    const Clock::duration least = is_much ? std::chrono::milliseconds(250) : std::chrono::seconds(1);
    const int rest_per_work = is_much ? 1 : 4;
    Clock::duration rest{0};
    while (rested(rest)) {
      const Clock::time_point start = Clock::now();
      rest = least;
      try {
        if (!show_next()) {
          site_.remove_old_files();
          continue;
        }
        // The first version's time is the mesh's, which stays.
        if (shown_++ > 0) rest = std::max(least, rest_per_work * (Clock::now() - start));
      } catch (const Stopped&) {
        return;
      } catch (const std::exception& error) {
        failed_(error.what());
      }
    }
  }
  // Shows the next snapshot, or more of the last one. False: there was nothing to show.
  bool show_next() {
    if (std::shared_ptr<const Snapshot> next = source_(); next && holds_view(*next)) unfinished_ = std::move(next);
    if (!unfinished_) return false;
    // Given up also if it fails, for it would fail again.
    std::shared_ptr<const Snapshot> shown = std::exchange(unfinished_, nullptr);
    const bool complete = site_.update(*shown, false, [this] {
      if (!rested(Clock::duration(0))) throw Stopped();
    });
    if (!complete) unfinished_ = std::move(shown);
    return true;
  }
  // Waits for that time; false, and at once, where this is to end.
  bool rested(Clock::duration time) {
    std::unique_lock lock(mutex_);
    return !stopped_.wait_for(lock, time, [this] { return stop_; });
  }

  LiveSite& site_;
  SnapshotSource source_;
  ShowingShare share_;
  std::function<void(const std::string&)> failed_;
  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stop_ = false;
  std::shared_ptr<const Snapshot> unfinished_;  // the page lacks some of its views; null: it has all
  std::size_t shown_ = 0;                       // versions
  std::thread thread_;                          // the last, for it uses the others
};

}  // namespace

LiveSite::LiveSite(SiteServer& server, const std::string& title, const LiveSiteTimes& times)
    : server_(server),
      times_(times),
      form_({SiteOptions{}.photographs, BlendOptions{}.border_width}, [](const Surface& surface) {
        return share_cells(surface, BlendOptions{}.border_width * surface.cells.size);
      }) {
  for (SiteFile& file : page_files(title, {.live = true})) server_.add(std::move(file));
  say_version(false);
}

void LiveSite::say_version(bool last) {
  server_.add(json_file("live.json", {{"version", version_}, {"last", last}}));
}

bool LiveSite::update(const Snapshot& snapshot, bool last, const CancelCheck& cancel_check) {
  bool complete = true;
  if (holds_view(snapshot)) {
    const std::chrono::milliseconds all_the_time = std::chrono::hours(24);
    FormVersion version = put_version(snapshot, last ? all_the_time : times_.for_views, cancel_check);
    complete = version.complete;
    server_.add({kTilesetName, "application/json", {version.tileset.begin(), version.tileset.end()}, {}});
    ++version_;
    replace_names(std::move(version.names));
  }
  say_version(last);
  return complete;
}

// Puts the files of a version on the server. Those of one that fails or is stopped do not stay there.
FormVersion LiveSite::put_version(const Snapshot& snapshot, std::chrono::milliseconds time_for_views,
                                  const CancelCheck& cancel_check) {
  std::mutex mutex;
  std::vector<std::string> names;  // of files that were put
  const PutFormFile put = [&](const FormFile& file) {
    std::string name = name_by_content(file.stem, file.ending, file.bytes);
    server_.add({name, file.type, {file.bytes.begin(), file.bytes.end()}, {}});
    const std::lock_guard lock(mutex);
    return names.emplace_back(std::move(name));
  };
  try {
    return form_.write(snapshot, time_for_views, put, cancel_check);
  } catch (...) {
    remove_unneeded(names);
    throw;
  }
}

// Removes the files of those names that are in no version that is kept.
void LiveSite::remove_unneeded(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    const auto has = [&](const std::vector<std::string>& of) { return std::binary_search(of.begin(), of.end(), name); };
    const bool is_needed = has(names_) || std::any_of(replaced_.begin(), replaced_.end(),
                                                      [&](const Replaced& version) { return has(version.names); });
    if (!is_needed) server_.remove(name);
  }
}

void LiveSite::replace_names(std::vector<std::string> names) {
  std::sort(names.begin(), names.end());
  replaced_.push_back({Clock::now(), std::exchange(names_, std::move(names))});
  remove_old_files();
}

void LiveSite::remove_old_files() {
  constexpr std::size_t kMostReplaced = 16;
  const Clock::time_point now = Clock::now();
  while (replaced_.size() > kMostReplaced || (replaced_.size() > 1 && replaced_.front().at + times_.kept <= now)) {
    const std::vector<std::string> old = std::move(replaced_.front().names);
    replaced_.pop_front();
    remove_unneeded(old);
  }
}

bool look_alike(const Snapshot& a, const Snapshot& b) {
  const bool same_parts = a.surface == b.surface && a.views == b.views && a.gains == b.gains;
  return same_parts && a.references.offsets == b.references.offsets && a.references.views == b.references.views &&
         a.cell_seen == b.cell_seen && a.cell_deviation == b.cell_deviation && a.vertex_colors == b.vertex_colors &&
         a.tiles.first_tile == b.tiles.first_tile && a.tiles.places == b.tiles.places;
}

std::shared_ptr<void> show_while_it_changes(LiveSite& site, SnapshotSource source, ShowingShare share,
                                            std::function<void(const std::string&)> failed) {
  return std::make_shared<LivePublisher>(site, std::move(source), share, std::move(failed));
}

}  // namespace lumatlas
