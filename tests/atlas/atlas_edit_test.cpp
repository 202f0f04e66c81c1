// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/atlas_edit.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "atlas/atlas.h"
#include "tests/support/scenes/wall_scenes.h"

namespace lumatlas {
namespace {

using Slots = std::vector<ViewSlot>;

constexpr ViewSlot kFirst{0}, kSecond{1};
constexpr CellId kCell{0}, kOther{1};

StoredView edit_view(const Surface& surface, const std::string& name) {
  return traced_view(surface, name, forward_camera(24, 16), position_photograph(24, 16));
}

// A store with view "a" in the first slot, to which the first cell refers.
struct EditedStore {
  std::shared_ptr<const Surface> surface = wall_and_panel(3);
  Atlas atlas{surface, 3};

  EditedStore() {
    AtlasEdit edit;
    edit.insert_at(kFirst, edit_view(*surface, "a"));
    edit.set_references(kCell, {kFirst});
    edit.set_gain(kFirst, glm::dvec3(2));
    edit.mark_seen(std::vector<CellPixels>{{kCell, 1}});
    atlas.commit(std::move(edit));
  }
};

TEST_CASE("an edit makes its changes in their order, so that later ones build on earlier ones") {
  EditedStore store;
  CHECK(store.atlas.references(kCell) == Slots{kFirst});
  CHECK(store.atlas.gain(kFirst) == glm::dvec3(2));
  AtlasEdit edit;
  CHECK(edit.empty());
  edit.set_references(kCell, {});
  edit.erase(kFirst);
  edit.insert_at(kFirst, edit_view(*store.surface, "b"));
  edit.insert_at(kSecond, edit_view(*store.surface, "c"));
  edit.set_references(kCell, {kSecond, kFirst});
  edit.replace(kSecond, edit_view(*store.surface, "d"));
  CHECK_FALSE(edit.empty());
  store.atlas.commit(std::move(edit));
  CHECK(store.atlas.view(kFirst)->name == "b");
  CHECK(store.atlas.view(kSecond)->name == "d");
  CHECK(store.atlas.gain(kFirst) == glm::dvec3(1));  // of another view
  CHECK(store.atlas.references(kCell) == Slots{kSecond, kFirst});
  CHECK(store.atlas.size() == 2);
}

TEST_CASE("an edit without changes changes nothing") {
  EditedStore store;
  store.atlas.commit(AtlasEdit());
  CHECK(store.atlas.size() == 1);
}

TEST_CASE("an edit of which any change is refused leaves the store as it was") {
  const std::vector<void (*)(AtlasEdit&, const Surface&)> wrong{
      [](AtlasEdit& edit, const Surface&) { edit.erase(kSecond); },  // erased already
      [](AtlasEdit& edit, const Surface&) { edit.set_references(kCell, {kSecond}); },
      [](AtlasEdit& edit, const Surface&) {
        edit.set_references(kCell, {kFirst, kFirst});
      },
      [](AtlasEdit& edit, const Surface&) { edit.set_references(CellId(99), {kFirst}); },
      [](AtlasEdit& edit, const Surface&) { edit.set_gain(kFirst, glm::dvec3(-1)); },
      [](AtlasEdit& edit, const Surface&) { edit.set_gain(kSecond, glm::dvec3(1)); },
      [](AtlasEdit& edit, const Surface&) {
        edit.mark_seen(std::vector<CellPixels>{{kOther, 1}, {CellId(99), 1}});
      },
      [](AtlasEdit& edit, const Surface& surface) { edit.insert_at(kFirst, edit_view(surface, "x")); },
      [](AtlasEdit& edit, const Surface& surface) { edit.insert_at(ViewSlot(7), edit_view(surface, "x")); },
      [](AtlasEdit& edit, const Surface& surface) { edit.replace(kSecond, edit_view(surface, "x")); },
      [](AtlasEdit& edit, const Surface&) { edit.insert_at(kSecond, StoredView()); },
      [](AtlasEdit& edit, const Surface&) { edit.erase(kFirst); },  // the first cell refers to it
  };
  EditedStore store;
  const std::shared_ptr<const StoredView> a = store.atlas.view(kFirst);
  for (std::size_t i = 0; i < wrong.size(); ++i) {
    CAPTURE(i);
    AtlasEdit edit;
    edit.mark_seen(std::vector<CellPixels>{{kOther, 1}});
    edit.set_references(kCell, {});
    edit.erase(kFirst);
    edit.insert_at(kFirst, edit_view(*store.surface, "b"));
    edit.set_gain(kFirst, glm::dvec3(5));
    edit.insert_at(kSecond, edit_view(*store.surface, "c"));
    edit.set_references(kOther, {kSecond});
    edit.set_references(kOther, {});
    edit.erase(kSecond);
    edit.set_references(kCell, {kFirst});
    wrong[i](edit, *store.surface);
    CHECK_THROWS_AS(store.atlas.commit(std::move(edit)), std::logic_error);  // std::invalid_argument is one
    CHECK(store.atlas.view(kFirst) == a);
    CHECK(store.atlas.view(kSecond) == nullptr);
    CHECK(store.atlas.gain(kFirst) == glm::dvec3(2));
    CHECK(store.atlas.references(kCell) == Slots{kFirst});
    CHECK(store.atlas.references(kOther).empty());
    CHECK(store.atlas.snapshot().cell_seen == std::vector<std::uint8_t>{1, 0, 0});
  }
  // The books still balance: the view can leave once no cell refers to it, and not before.
  CHECK_THROWS_AS(store.atlas.erase(kFirst), std::logic_error);
  store.atlas.set_references(kCell, {});
  store.atlas.erase(kFirst);
  CHECK(store.atlas.size() == 0);
}

TEST_CASE("snapshots have whole edits while other threads commit them") {
  EditedStore store;
  const StoredView a = edit_view(*store.surface, "a"), b = edit_view(*store.surface, "b");
  std::atomic<std::size_t> snapshots = 0;
  std::thread writer([&] {
    for (int i = 0; snapshots < 50; ++i) {
      const ViewSlot old = i % 2 == 0 ? kFirst : kSecond, next = i % 2 == 0 ? kSecond : kFirst;
      AtlasEdit edit;
      edit.set_references(kCell, {});
      edit.erase(old);
      edit.insert_at(next, i % 2 == 0 ? b : a);
      edit.set_references(kCell, {next});
      store.atlas.commit(std::move(edit));
    }
  });
  std::size_t halves = 0;
  for (; snapshots < 50; ++snapshots) {
    const Snapshot snapshot = store.atlas.snapshot();
    const auto views = std::count_if(snapshot.views.begin(), snapshot.views.end(), [](const auto& v) { return v; });
    const bool is_whole =
        views == 1 && snapshot.references.views.size() == 1 && snapshot.views[snapshot.references.views[0]] != nullptr;
    halves += is_whole ? 0 : 1;
  }
  writer.join();
  CHECK(halves == 0);
}

}  // namespace
}  // namespace lumatlas
