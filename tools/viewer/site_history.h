// SPDX-License-Identifier: GPL-3.0-or-later
// The last written state of a site that changes, so that only new parts are written and fetched. Files carry the number
// of the version in which they changed.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "blend/tables/zone_mesh.h"

namespace lumatlas {

struct SiteHistory {
  struct View {
    std::shared_ptr<const StoredView> view;  // the view that was written; null: none was
    std::uint64_t photograph = 0, mask = 0;  // versions in which they changed
  };

  struct Arrays {
    nlohmann::json described = nlohmann::json::object();  // the scene's JSON for it, with its file
    std::vector<std::uint8_t> packed;                     // the bytes that were written
  };

  std::uint64_t version = 0;               // 0: nothing was written yet
  std::shared_ptr<const Surface> surface;  // that the mesh was made of
  nlohmann::json mesh;                     // the scene's JSON for it
  ZoneCells zone_cells;
  std::vector<std::uint32_t> sources;  // for each of the mesh's vertices, that of the surface
  std::vector<View> views;             // one per view slot
  std::map<std::string, Arrays> arrays;
  bool complete = true;  // false: there was no time for some views, which are as they were before
};

// Returns whether a page that has one surface's mesh need not load the other's.
[[nodiscard]] bool same_mesh(const Surface& a, const Surface& b);

}  // namespace lumatlas
