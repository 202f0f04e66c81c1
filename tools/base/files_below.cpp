// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/files_below.h"

#include <algorithm>
#include <cstddef>
#include <set>

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostEntries = 1'000'000;

// Returns whether `path` is `folder` or below it; both are canonical.
bool is_in(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

class Lister {
 public:
  Lister(const fs::path& folder, const std::function<bool(const fs::path&)>& passes_over)
      : folder_(folder), passes_over_(passes_over) {}

  FilesBelow run() {
    root_ = fs::canonical(folder_, result_.error);
    if (result_.error) return result_;
    list(folder_);
    // A linked folder may hold further links.
    while (!links_.empty()) {
      std::vector<fs::path> links;
      links.swap(links_);
      std::sort(links.begin(), links.end());
      for (const fs::path& link : links) follow(link);
    }
    std::sort(result_.names.begin(), result_.names.end());
    return std::move(result_);
  }

 private:
  void follow(const fs::path& link) {
    std::error_code error;
    const fs::path target = fs::canonical(link, error);
    if (!error && !is_in(root_, target)) list(link);
  }

  // Lists a folder and those below that are no links.
  void list(const fs::path& folder) {
    std::error_code error;
    if (!listed_.insert(fs::canonical(folder, error)).second) return;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
      if (++entries_ > kMostEntries) return;
      if (!passes_over_ || !passes_over_(entry->path())) take(*entry);
    }
    if (error && !result_.error) result_.error = error;
  }

  void take(const fs::directory_entry& entry) {
    std::error_code ignored;
    if (entry.is_regular_file(ignored)) {
      result_.names.push_back(entry.path().lexically_relative(folder_).generic_string());
    } else if (!entry.is_directory(ignored)) {
      return;
    } else if (entry.is_symlink(ignored)) {
      links_.push_back(entry.path());
    } else {
      list(entry.path());
    }
  }

  const fs::path& folder_;
  const std::function<bool(const fs::path&)>& passes_over_;
  fs::path root_;
  std::set<fs::path> listed_;  // canonical
  std::vector<fs::path> links_;
  std::size_t entries_ = 0;
  FilesBelow result_;
};

}  // namespace

FilesBelow files_below(const fs::path& folder, const std::function<bool(const fs::path&)>& passes_over) {
  return Lister(folder, passes_over).run();
}

}  // namespace lumatlas
