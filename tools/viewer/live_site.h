// SPDX-License-Identifier: GPL-3.0-or-later
// A model that changes, in the browser: the page asks some times a second which version there is, and fetches what
// changed since its own.
#pragma once

#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/model/live_form.h"
#include "atlas/snapshot.h"
#include "mesh/cancel_check.h"
#include "tools/viewer/http/site_server.h"
#include "tools/viewer/site.h"

namespace lumatlas {

struct LiveSiteTimes {
  // A version appears after this time with the views that were written by then, at least one of those that changed, new
  // photographs first. The others come in the next version.
  std::chrono::milliseconds for_views = std::chrono::seconds(1);
  // The files of a version stay for this time after the next one appears, for pages that still fetch them, but those of
  // 16 versions at most.
  std::chrono::milliseconds kept = std::chrono::seconds(10);
};

class LiveSite {
 public:
  // Puts the page on the server, which must outlive this and may be serving; the page waits for a model. Photographs
  // are coded for speed.
  LiveSite(SiteServer& server, const std::string& title, const LiveSiteTimes& times = {});

  // Shows the model as it is now. `last`: nothing will follow. A snapshot without a view changes nothing else. Returns
  // false if there was no time for all of its photographs; another call with the same model goes on with them. Throws
  // std::invalid_argument unless the snapshot passes check(), and what `cancel_check` throws, which is called many
  // times. The page then keeps what it has.
  bool update(const Snapshot& snapshot, bool last, const CancelCheck& cancel_check = {});

  // Removes files of versions that were replaced long enough ago, as update() does.
  void remove_old_files();

 private:
  void say_version(bool last);
  FormVersion put_version(const Snapshot& snapshot, std::chrono::milliseconds time_for_views,
                          const CancelCheck& cancel_check);
  void remove_unneeded(const std::vector<std::string>& names);
  void replace_names(std::vector<std::string> names);

  SiteServer& server_;
  LiveSiteTimes times_;
  LiveForm form_;
  std::uint64_t version_ = 0;  // 0: nothing was shown yet
  // The files of a version, and when the next one appeared.
  struct Replaced {
    std::chrono::steady_clock::time_point at;
    std::vector<std::string> names;
  };
  std::vector<std::string> names_;  // files of the last version, sorted
  std::deque<Replaced> replaced_;   // versions before that are kept, the oldest first; the one before is
};

// Returns whether two snapshots of one atlas show the same: the same surface and views, by their addresses, and equal
// tables.
[[nodiscard]] bool look_alike(const Snapshot& a, const Snapshot& b);

// Returns the next snapshot to show, or null: nothing new. The snapshot is kept until the page has all of it, or
// another one that holds a view takes its place.
using SnapshotSource = std::function<std::shared_ptr<const Snapshot>()>;

// The share of the time that goes into showing a model: `little`, a fifth, where others wait for the model, `much`,
// half, where they watch it.
enum class ShowingShare { little, much };

// Asks `source` for what changed and shows it, on a thread of its own, until the returned object is destroyed, which
// may wait for one step of the work. At most a share of the time goes into it. `failed` is called on that thread with
// the reason why a version is not shown.
[[nodiscard]] std::shared_ptr<void> show_while_it_changes(LiveSite& site, SnapshotSource source, ShowingShare share,
                                                          std::function<void(const std::string&)> failed);

}  // namespace lumatlas
