// SPDX-License-Identifier: GPL-3.0-or-later
// A model as a site: a page that any web server hosts, and beside it the model in the form that every model has
// (atlas/README.md), in few bytes. The page needs a browser with
// WebGL 2 and asks no other server for anything.
//
// Its shaders are those of blend/, so that it shows the picture that `lumatlas render` draws.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include "atlas/images/scaled_view.h"
#include "atlas/model/model_form.h"
#include "atlas/snapshot.h"
#include "atlas/views/validity.h"
#include "mesh/cancel_check.h"

namespace lumatlas {

// The generator that a page names.
inline constexpr const char* kSiteGenerator = "lumatlas export --to web";

struct SiteOptions {
  std::string title = "lumatlas";
  std::string unit;       // name of the unit of the model's lengths; empty: not known
  std::string page_file;  // JSON of the owner's file (page_file.h); empty: there is none
  ImageCoding photographs{ImageFormat::jpeg, 90};
  ValidityOptions validity;                               // that the views' masks were made with
  std::uint32_t most_side_px = kMostSidePx;               // photographs with a longer side are scaled, all alike
  std::size_t chunk_faces = FormOptions{}.chunk_faces;    // most faces of a chunk of the surface
  std::size_t coarse_faces = FormOptions{}.coarse_faces;  // of a coarse surface
  std::size_t listed_views = FormOptions{}.listed_views;  // most views that the tileset lists itself
};

// The model that a page shows.
struct ShownModel {
  std::string file = "tileset.json";  // relative to the page: tileset.json or a .glb
  bool live = false;                  // the page asks again and again which version there is: see live_site.h
  std::string unit{};                 // name of the unit of the model's lengths; empty: not known
  bool page_file = false;             // the page asks for the owner's file (page_file.h)
};

struct SiteFile {
  std::string name;  // relative to the site, with '/'
  std::string type;  // media type
  std::vector<std::uint8_t> bytes;
  std::filesystem::path path{};  // not empty: a server reads the file from there instead, when it is asked for
};

// The sizes of the files that a model became.
struct SiteFacts {
  std::uint64_t page_bytes = 0;        // HTML, script, style, shaders
  std::uint64_t other_page_bytes = 0;  // script and shaders under the names that other pages know
  std::uint64_t scene_bytes = 0;       // the tileset, the coarse surface and the poster: the first picture
  std::uint64_t mesh_bytes = 0;        // the surface, with cells and references, and the views' file
  std::uint64_t photograph_bytes = 0;  // photographs and thumbnails
  std::uint64_t mask_bytes = 0;
  std::uint32_t views = 0;
  double scale = 1;  // scale of the photographs, if one was longer than a texture of every browser may be

  [[nodiscard]] std::uint64_t bytes() const {
    return page_bytes + other_page_bytes + scene_bytes + mesh_bytes + photograph_bytes + mask_bytes;
  }
};

// Returns how often write_site() calls its progress callback.
[[nodiscard]] std::size_t site_ticks(const Snapshot& snapshot);

// Passes each file of the site to `put`, one at a time: the model in few bytes, packed as model_form.h says, then the
// page, index.html last. index.html and tileset.json come after the files that they name, whose names hold a digest of
// their bytes. A file of that name is the same in every version of every site, so no cache mixes versions. Throws
// std::invalid_argument unless the snapshot passes check() and holds a view.
SiteFacts write_site(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
                     const CancelCheck& cancel_check = {});

// The page's own files under names that stay, for a server that forbids caches to keep them: HTML, script, style,
// shaders. Only the title and what it shows differ from model to model.
[[nodiscard]] std::vector<SiteFile> page_files(const std::string& title, const ShownModel& shown = {});

// Into a folder, which must exist. Throws InputError if a file cannot be written.
SiteFacts write_site_folder(const std::filesystem::path& folder, const Snapshot& snapshot, const SiteOptions& options,
                            const CancelCheck& cancel_check = {});

// Returns the title of a model's page: the name of its file or folder.
[[nodiscard]] std::string title_of(const std::filesystem::path& model);

// Writes the site as one HTML file that opens from a disk. The caller checks whether the stream has failed.
SiteFacts write_one_page(std::ostream& file, const Snapshot& snapshot, const SiteOptions& options,
                         const CancelCheck& cancel_check = {});

}  // namespace lumatlas
