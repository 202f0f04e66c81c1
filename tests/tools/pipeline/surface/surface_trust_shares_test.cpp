// SPDX-License-Identifier: GPL-3.0-or-later
// A wall and a panel of cells with known deviations, counted as two photographs see them.
#include "tools/pipeline/surface/surface_trust_shares.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "mesh/visibility/visibility.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

TEST_CASE("shares of trust count pixels of surface by what its deviation shifts them") {
  const Snapshot snapshot = small_snapshot();
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(snapshot.surface->mesh);
  const std::size_t cells = snapshot.cell_seen.size();
  const auto shares = [&](float deviation, std::uint8_t measured) {
    return trust_shares(snapshot, {std::vector<float>(cells, deviation), std::vector<std::uint8_t>(cells, measured)},
                        *visibility);
  };
  const TrustShares exact = shares(0, 1);
  CHECK(exact.within_1_px == 1);
  CHECK(exact.within_2_px == 1);
  CHECK(exact.within_4_px == 1);
  CHECK(exact.measured == 1);
  const TrustShares off = shares(1e3f, 0);
  CHECK(off.within_4_px == 0);
  CHECK(off.measured == 0);
  // At depth 4 the wall shifts by half as much as the panel before it, so that some bound parts them.
  bool parted = false;
  for (const float deviation : {0.5f, 0.7f, 1.0f, 1.4f, 2.0f}) {
    const TrustShares some = shares(deviation, 1);
    CHECK(some.within_1_px <= some.within_2_px);
    CHECK(some.within_2_px <= some.within_4_px);
    parted = parted || (some.within_1_px > 0 && some.within_1_px < 1);
  }
  CHECK(parted);
}

TEST_CASE("a store that holds no photograph trusts nothing") {
  const auto surface = wall_and_panel();
  const Snapshot empty = Atlas(surface, 2).snapshot();
  const std::size_t cells = empty.cell_seen.size();
  const TrustShares none = trust_shares(empty, {std::vector<float>(cells, 0), std::vector<std::uint8_t>(cells, 1)},
                                        *make_ray_visibility(surface->mesh));
  CHECK(none.within_1_px == 0);
  CHECK(none.measured == 0);
}

}  // namespace
}  // namespace lumatlas
