// SPDX-License-Identifier: GPL-3.0-or-later
// The files of a model that changes, version after version: only what is new is made, and what is as it was keeps its
// name.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atlas/model/model_form.h"

namespace lumatlas {

// One version of a model: tileset.json, and the names of all other files.
struct FormVersion {
  std::string tileset;
  std::vector<std::string> names;
  bool complete = true;  // false: there was no time for some views, which are as they were before
};

struct LiveFormOptions {
  ImageCoding photographs{};
  double border_width = 0;             // of the fade between cells, which shares are of, as a share of the cell size
  std::size_t least_chunked = 20'000;  // faces of a surface that is cut into chunks
  double chunk_cells = 16;             // side of a chunk's cube, in cell sizes, > 0
};

class LiveForm {
 public:
  // Returns how the cells of a surface fade into each other. It is asked once for each surface, or the part of it that
  // has changed.
  using SharesOf = std::function<CellShares(const Surface& surface)>;

  LiveForm(const LiveFormOptions& options, SharesOf shares_of);
  ~LiveForm();
  LiveForm(const LiveForm&) = delete;
  LiveForm& operator=(const LiveForm&) = delete;

  // Passes the version's files to `put`, those that are as they were too if making them takes no time. The surface is a
  // .gltf whose mesh, colours and tables are files of their own. A large surface is cut into chunks by a grid, each of
  // them such a file. A chunk keeps its mesh while its surface and its surroundings are as they were, and then its
  // colours too unless one differs by more than 8 of 255. A surface with a far sphere is not cut. Views have the
  // numbers of their slots: null where a slot is free, or a photograph has not been written yet. Views that changed are
  // written for `time_for_views`, at least one of them: first those with a photograph that no version has, then those
  // that were written longest ago. Several threads call `put`. Throws std::invalid_argument unless the snapshot passes
  // check() and holds a view, and what `cancel_check` throws, which is called many times; the next version is then made
  // as if this one had not been.
  FormVersion write(const Snapshot& snapshot, std::chrono::milliseconds time_for_views, const PutFormFile& put,
                    const CancelCheck& cancel_check = {});

 private:
  struct State;
  LiveFormOptions options_;
  SharesOf shares_of_;
  std::shared_ptr<const State> state_;  // what was written last
};

// Returns whether one surface's mesh, cut into cells, is the other's.
[[nodiscard]] bool same_mesh(const Surface& a, const Surface& b);

}  // namespace lumatlas
