// SPDX-License-Identifier: GPL-3.0-or-later
// A model that changes, in the browser: the page asks some times a minute which version there is, and fetches what
// changed since its own.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/model/live_form.h"
#include "atlas/snapshot.h"
#include "mesh/cancel_check.h"
#include "tools/viewer/site.h"
#include "tools/viewer/site_server.h"

namespace lumatlas {

class LiveSite {
 public:
  // Puts the page on the server, which must outlive this and may be serving; the page waits for a model. Photographs
  // are coded for speed. `time_for_views`: a version appears after this time with the photographs that it has, at least
  // one more than the version before. The others come in the next version.
  LiveSite(SiteServer& server, const std::string& title, std::chrono::seconds time_for_views = std::chrono::seconds(3));

  // Shows the model as it is now. `last`: nothing will follow. A snapshot without a view changes nothing else. Returns
  // false if there was no time for all of its photographs; another call with the same model goes on with them. Throws
  // std::invalid_argument unless the snapshot passes check(), and what `cancel_check` throws, which is called many
  // times. The page then keeps what it has.
  bool update(const Snapshot& snapshot, bool last, const CancelCheck& cancel_check = {});

 private:
  void say_version(bool last);

  SiteServer& server_;
  std::chrono::seconds time_for_views_;
  LiveForm form_;
  std::uint64_t version_ = 0;                     // 0: nothing was shown yet
  std::vector<std::string> names_, older_names_;  // files of the last version, and of the one before
};

// Returns whether two snapshots of one atlas show the same: the same surface and views, by their addresses, and equal
// tables.
[[nodiscard]] bool look_alike(const Snapshot& a, const Snapshot& b);

// Returns the next snapshot to show, or null: nothing new. The snapshot is kept until the page has all of it, or
// another one that holds a view takes its place.
using SnapshotSource = std::function<std::shared_ptr<const Snapshot>()>;

// Asks `source` for what changed and shows it, on a thread of its own, until the returned object is destroyed, which
// may wait for one step of the work. At most a fifth of the time goes into it. `failed` is called on that thread with
// the reason why a version is not shown.
[[nodiscard]] std::shared_ptr<void> show_while_it_changes(LiveSite& site, SnapshotSource source,
                                                          std::function<void(const std::string&)> failed);

}  // namespace lumatlas
