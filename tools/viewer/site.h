// SPDX-License-Identifier: GPL-3.0-or-later
// A model as a site: files that any web server hosts, with the page that shows them. The page needs a browser with
// WebGL 2 and asks no other server for anything.
//
// Its shaders are those of blend/, so that it shows the picture that `lumatlas render` draws.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/blend_options.h"
#include "mesh/tick.h"
#include "tools/viewer/scaled_view.h"
#include "tools/viewer/site_history.h"

namespace lumatlas {

// The generator that a page names.
inline constexpr const char* kSiteGenerator = "lumatlas export --to web";

struct SiteOptions {
  std::string title = "lumatlas";
  ImageCoding photographs{ImageFormat::jpeg, 90};
  BlendOptions blend;
  std::uint32_t most_side_px = kMostSidePx;  // photographs with a longer side are scaled, all alike
  std::chrono::seconds time_for_views =
      std::chrono::hours(24);  // time to write a version's views; at least one that is new is written
  bool live = false;           // the page asks again and again for what changed: see live_site.h
};

struct SiteFile {
  std::string name;  // relative to the site, with '/'
  std::string type;  // media type
  std::vector<std::uint8_t> bytes;
};

// The sizes of the files that a model became.
struct SiteFacts {
  std::uint64_t page_bytes = 0;        // HTML, script, style, shaders
  std::uint64_t other_page_bytes = 0;  // script and shaders under the names that other pages know
  std::uint64_t scene_bytes = 0;       // the scene's JSON and a coarse mesh: the first picture
  std::uint64_t mesh_bytes = 0;
  std::uint64_t table_bytes = 0;       // references
  std::uint64_t photograph_bytes = 0;  // photographs and thumbnails
  std::uint64_t mask_bytes = 0;
  std::uint32_t views = 0;
  double scale = 1;  // scale of the photographs, if one was longer than a texture of every browser may be

  [[nodiscard]] std::uint64_t bytes() const {
    return page_bytes + other_page_bytes + scene_bytes + mesh_bytes + table_bytes + photograph_bytes + mask_bytes;
  }
};

// How many ticks write_site() gives.
[[nodiscard]] std::size_t site_ticks(const Snapshot& snapshot);

// Passes each file of the site to `put`, one at a time, scene.json last. index.html and scene.json name the others,
// whose names hold a digest of their bytes. A file of that name is the same in every version of every site, so no cache
// mixes versions. Throws std::invalid_argument unless the snapshot passes check() and holds a view.
SiteFacts write_site(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
                     const Tick& tick = {});

// The page's own files under names that stay, for a server that forbids caches to keep them: HTML, script, style,
// shaders. Only the title differs from model to model.
[[nodiscard]] std::vector<SiteFile> page_files(const SiteOptions& options);

// The rest of the site, as far as it is not as it was written last; the scene's own file, which names the others, comes
// last. Returns the names of all files of this version but that one. Throws as write_site() does, and what `tick`
// throws; the history is then as it was.
std::vector<std::string> write_site_version(const Snapshot& snapshot, const SiteOptions& options, SiteHistory& history,
                                            const std::function<void(SiteFile)>& put, const Tick& tick = {});

// Into a folder, which must exist. Throws InputError if a file cannot be written.
SiteFacts write_site_folder(const std::filesystem::path& folder, const Snapshot& snapshot, const SiteOptions& options,
                            const Tick& tick = {});

// Returns the title of a model's page: the name of its file or folder.
[[nodiscard]] std::string title_of(const std::filesystem::path& model);

// The same in one HTML file that opens from a disk. The caller looks whether the stream has failed.
SiteFacts write_one_page(std::ostream& file, const Snapshot& snapshot, const SiteOptions& options,
                         const Tick& tick = {});

}  // namespace lumatlas
