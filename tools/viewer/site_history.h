// SPDX-License-Identifier: GPL-3.0-or-later
// What a site that changes was when it was written last, so that only what is new is written and fetched. Files carry
// the number of the version that they changed in.
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
    std::shared_ptr<const StoredView> view;  // as it was written; null: none was
    std::uint64_t photograph = 0, mask = 0;  // versions in which they changed
  };

  struct Arrays {
    nlohmann::json described = nlohmann::json::object();  // as the scene does it, with their file
    std::vector<std::uint8_t> packed;                     // as they were written
  };

  std::uint64_t version = 0;               // 0: nothing was written yet
  std::shared_ptr<const Surface> surface;  // that the mesh was made of
  nlohmann::json mesh;                     // as the scene describes it
  ZoneCells zone_cells;
  std::vector<std::uint32_t> sources;  // of the mesh's vertices, those of the surface
  std::vector<View> views;             // by slot
  std::map<std::string, Arrays> arrays;
  bool complete = true;  // false: there was no time for some views, which are as they were before
};

// Whether a page that has the one's mesh need not load the other's.
[[nodiscard]] bool same_mesh(const Surface& a, const Surface& b);

}  // namespace lumatlas
