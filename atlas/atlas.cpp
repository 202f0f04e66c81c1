// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/atlas.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "atlas/snapshot_maker.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

void require_gain(ViewSlot slot, const glm::dvec3& gain) {
  for (int channel = 0; channel < 3; ++channel) {
    if (gain[channel] >= kLeastExposureGain && gain[channel] <= kMostExposureGain) continue;
    throw std::invalid_argument("atlas: gain[" + std::to_string(channel) + "] of slot " + std::to_string(slot) +
                                " is " + number_text(gain[channel]) + ", must be in [1e-6, 1e6]");
  }
}

void require_previous_cells(std::span<const CellId> previous_cell, std::size_t cells, std::size_t cells_before) {
  if (previous_cell.size() != cells) {
    throw std::invalid_argument("atlas: previous_cell has " + std::to_string(previous_cell.size()) +
                                " entries, must have one per cell of the new surface, " + std::to_string(cells));
  }
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (previous_cell[cell] < cells_before || previous_cell[cell] == CellId::none) continue;
    throw std::invalid_argument("atlas: previous_cell[" + std::to_string(cell) + "] is " +
                                std::to_string(previous_cell[cell]) + ", must be below the number of cells before, " +
                                std::to_string(cells_before));
  }
}

// For each cell of the surface before, which cell it is now.
std::vector<std::vector<CellId>> cells_that_were(std::span<const CellId> previous_cell, std::size_t cells_before) {
  std::vector<std::vector<CellId>> now(cells_before);
  for (CellId cell{0}; cell < previous_cell.size(); ++cell) {
    if (previous_cell[cell] != CellId::none) now[previous_cell[cell]].push_back(cell);
  }
  return now;
}

std::vector<ShownCell> renumbered(std::span<const ShownCell> shown, const std::vector<std::vector<CellId>>& cells_now) {
  std::vector<ShownCell> renumbered;
  for (const ShownCell& part : shown) {
    for (const CellId cell : cells_now[part.cell]) renumbered.push_back({part.tile, cell, part.pixels});
  }
  std::sort(renumbered.begin(), renumbered.end(),
            [](const ShownCell& a, const ShownCell& b) { return std::tie(a.tile, a.cell) < std::tie(b.tile, b.cell); });
  return renumbered;
}

// Renumbers the cells that the tiles of each view slot show.
class RenumberedTiles {
 public:
  explicit RenumberedTiles(std::vector<std::vector<CellId>> cells_now) : cells_now_(std::move(cells_now)) {}

  // Numbers the cells anew of those slots that show something else than at the call before.
  void follow(const std::vector<SharedShownCells>& shown) {
    before_.resize(shown.size());
    now_.resize(shown.size());
    for (std::size_t slot = 0; slot < shown.size(); ++slot) {
      if (before_[slot] == shown[slot]) continue;
      now_[slot] = shown[slot]->empty()
                       ? shown[slot]
                       : std::make_shared<const std::vector<ShownCell>>(renumbered(*shown[slot], cells_now_));
      before_[slot] = shown[slot];
    }
  }
  [[nodiscard]] std::vector<SharedShownCells>& now() { return now_; }

 private:
  std::vector<std::vector<CellId>> cells_now_;  // see cells_that_were()
  std::vector<SharedShownCells> before_, now_;
};

// Holds the id of the thread that made it, as long as it lives.
class NotedThread {
 public:
  explicit NotedThread(std::atomic<std::thread::id>& id) : id_(id) { id_ = std::this_thread::get_id(); }
  ~NotedThread() { id_ = std::thread::id(); }
  NotedThread(const NotedThread&) = delete;
  NotedThread& operator=(const NotedThread&) = delete;

 private:
  std::atomic<std::thread::id>& id_;
};

const SharedSlots& no_slots() {
  static const SharedSlots none = std::make_shared<const std::vector<ViewSlot>>();
  return none;
}

const SharedShownCells& nothing_shown() {
  static const SharedShownCells nothing = std::make_shared<const std::vector<ShownCell>>();
  return nothing;
}

// Checks of a view that need no look at the store, and so no lock.
void check_view(const StoredView& view, std::span<const ShownCell> shown, const TileOptions& layout) {
  check(view);
  require_shown_cells_of(view.name, view.camera, shown, layout);
}

void require_each_once(CellId cell, std::span<const ViewSlot> slots) {
  for (auto slot = slots.begin(); slot != slots.end(); ++slot) {
    if (std::find(slots.begin(), slot, *slot) == slot) continue;
    throw std::invalid_argument("atlas: the references of cell " + std::to_string(cell) + " have slot " +
                                std::to_string(*slot) + " twice, must have each once");
  }
}

void require_each_once(std::span<const ViewPose> poses) {
  std::vector<ViewSlot> slots;
  slots.reserve(poses.size());
  for (const ViewPose& pose : poses) slots.push_back(pose.slot);
  std::sort(slots.begin(), slots.end());
  const auto twice = std::adjacent_find(slots.begin(), slots.end());
  if (twice == slots.end()) return;
  throw std::invalid_argument("atlas: the poses have slot " + std::to_string(*twice) + " twice, must have each once");
}

void check_poses(std::span<const ViewPose> poses) {
  require_each_once(poses);
  for (const ViewPose& pose : poses) check(pose.camera);
}

// Returns the view with another pose, or lens.
std::shared_ptr<const StoredView> view_moved_to(const StoredView& view, const Camera& camera) {
  if (camera.width != view.camera.width || camera.height != view.camera.height) {
    throw std::invalid_argument("view " + view.name + ": the new pose has an image of " +
                                size_text(camera.width, camera.height) + ", must be as large as before, " +
                                size_text(view.camera.width, view.camera.height));
  }
  return std::make_shared<const StoredView>(StoredView{view.name, camera, view.photograph, view.mask});
}

std::vector<std::shared_ptr<const StoredView>> moved_views(std::span<const std::shared_ptr<const StoredView>> views,
                                                           std::span<const ViewPose> poses) {
  std::vector<std::shared_ptr<const StoredView>> moved;
  moved.reserve(poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i) moved.push_back(view_moved_to(*views[i], poses[i].camera));
  return moved;
}

const Surface& checked(const std::shared_ptr<const Surface>& surface) {
  if (!surface) throw std::invalid_argument("atlas: surface is null");
  check(*surface);
  return *surface;
}

}  // namespace

Atlas::Atlas(std::shared_ptr<const Surface> surface, std::uint32_t max_views, const TileOptions& layout,
             TilePolicy policy)
    : layout_(layout), policy_(std::move(policy)), surface_(std::move(surface)) {
  const std::size_t cells = checked(surface_).cells.cells.size();
  if (max_views == 0) throw std::invalid_argument("atlas: max_views is 0, must be at least 1");
  check(layout);
  views_.resize(max_views);
  shown_.assign(max_views, nothing_shown());
  gains_.assign(max_views, glm::dvec3(1));
  tenants_.assign(max_views, 0);
  references_to_slot_.assign(max_views, 0);
  references_.assign(cells, no_slots());
  cell_seen_.assign(cells, 0);
  cell_changed_.assign(cells, 0);
  // Each has a cell once at most, so that noting one never fails.
  changed_cells_.reserve(cells);
  newly_seen_.reserve(cells);
}

Atlas::~Atlas() = default;

std::shared_ptr<const Surface> Atlas::surface() const {
  const std::scoped_lock lock(mutex_);
  return surface_;
}

std::uint32_t Atlas::size() const {
  const std::scoped_lock lock(mutex_);
  return static_cast<std::uint32_t>(std::count_if(views_.begin(), views_.end(), [](const auto& view) { return view; }));
}

// Checks what needs no look at the store.
void Atlas::check_change(const AtlasEdit::Change& change, const TileOptions& layout) {
  if (const auto* view = std::get_if<AtlasEdit::ViewChange>(&change); view != nullptr && view->view) {
    check_view(*view->view, *view->shown, layout);
  } else if (const auto* gain = std::get_if<AtlasEdit::GainChange>(&change)) {
    require_gain(gain->slot, gain->gain);
  } else if (const auto* references = std::get_if<AtlasEdit::ReferencesChange>(&change)) {
    require_each_once(references->cell, *references->slots);
  }
}

Atlas::Entry Atlas::entry_of(StoredView view, std::vector<ShownCell> shown) const {
  check_view(view, shown, layout_);
  return {std::make_shared<const StoredView>(std::move(view)),
          std::make_shared<const std::vector<ShownCell>>(std::move(shown))};
}

ViewSlot Atlas::insert(StoredView view, std::vector<ShownCell> shown) {
  Entry entry = entry_of(std::move(view), std::move(shown));
  const std::scoped_lock lock(mutex_);
  const auto free_slot = std::find(views_.begin(), views_.end(), nullptr);
  if (free_slot == views_.end()) throw std::logic_error("atlas: insert into a full store");
  const ViewSlot slot(static_cast<std::uint32_t>(free_slot - views_.begin()));
  put(slot, std::move(entry));
  return slot;
}

void Atlas::insert_at(ViewSlot slot, StoredView view, std::vector<ShownCell> shown) {
  AtlasEdit edit;
  edit.insert_at(slot, std::move(view), std::move(shown));
  commit(std::move(edit));
}

// Under the lock, into a free slot.
void Atlas::put(ViewSlot slot, Entry entry) {
  require_cells_of(entry.view->name, *entry.shown);
  views_[slot] = std::move(entry.view);
  shown_[slot] = std::move(entry.shown);
  tenants_[slot] = ++inserted_;
}

void Atlas::replace(ViewSlot slot, StoredView view, std::vector<ShownCell> shown) {
  AtlasEdit edit;
  edit.replace(slot, std::move(view), std::move(shown));
  commit(std::move(edit));
}

std::vector<std::shared_ptr<const StoredView>> Atlas::stored_at(std::span<const ViewPose> poses) const {
  std::vector<std::shared_ptr<const StoredView>> views;
  views.reserve(poses.size());
  const std::scoped_lock lock(mutex_);
  for (const ViewPose& pose : poses) {
    require_stored(pose.slot);
    views.push_back(views_[pose.slot]);
  }
  return views;
}

// Moves those of the views that another thread has changed since they were `before`. Called with the lock held.
void Atlas::keep_up(std::span<const ViewPose> poses, std::span<const std::shared_ptr<const StoredView>> before,
                    std::vector<std::shared_ptr<const StoredView>>& after) const {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    require_stored(poses[i].slot);
    const std::shared_ptr<const StoredView>& now = views_[poses[i].slot];
    if (now != before[i]) after[i] = view_moved_to(*now, poses[i].camera);
  }
}

void Atlas::swap_views(std::span<const ViewPose> poses,
                       std::vector<std::shared_ptr<const StoredView>>& after) noexcept {
  for (std::size_t i = 0; i < poses.size(); ++i) views_[poses[i].slot].swap(after[i]);
}

// Makes the moved views without the lock, and under it once more those that other threads have changed meanwhile.
void Atlas::set_poses(std::span<const ViewPose> poses) {
  check_poses(poses);
  const std::vector<std::shared_ptr<const StoredView>> before = stored_at(poses);
  std::vector<std::shared_ptr<const StoredView>> after = moved_views(before, poses);  // in the end the old ones
  const std::scoped_lock lock(mutex_);
  keep_up(poses, before, after);
  swap_views(poses, after);
}

void Atlas::replace_mask(ViewSlot slot, std::shared_ptr<const ViewMask> mask, std::vector<ShownCell> shown) {
  const std::shared_ptr<const StoredView> before = view(slot);
  if (!before) throw std::logic_error("atlas: slot " + std::to_string(slot) + " holds no view");
  StoredView masked = *before;
  masked.mask = std::move(mask);
  Entry entry = entry_of(std::move(masked), std::move(shown));
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  require_cells_of(entry.view->name, *entry.shown);
  if (views_[slot] != before) {  // another thread has moved or replaced it meanwhile
    StoredView now = *views_[slot];
    now.mask = entry.view->mask;
    check_view(now, *entry.shown, layout_);
    entry.view = std::make_shared<const StoredView>(std::move(now));
  }
  views_[slot].swap(entry.view);  // the old view is freed after the lock
  shown_[slot].swap(entry.shown);
}

void Atlas::erase(ViewSlot slot) {
  AtlasEdit edit;
  edit.erase(slot);
  commit(std::move(edit));
}

std::shared_ptr<const StoredView> Atlas::view(ViewSlot slot) const {
  const std::scoped_lock lock(mutex_);
  require_slot(slot);
  return views_[slot];
}

SharedShownCells Atlas::shown(ViewSlot slot) const {
  const std::scoped_lock lock(mutex_);
  require_slot(slot);
  return shown_[slot];
}

void Atlas::set_gain(ViewSlot slot, const glm::dvec3& gain) {
  AtlasEdit edit;
  edit.set_gain(slot, gain);
  commit(std::move(edit));
}

glm::dvec3 Atlas::gain(ViewSlot slot) const {
  const std::scoped_lock lock(mutex_);
  require_stored(slot);
  return gains_[slot];
}

void Atlas::set_references(CellId cell, std::vector<ViewSlot> slots) {
  AtlasEdit edit;
  edit.set_references(cell, std::move(slots));
  commit(std::move(edit));
}

std::vector<ViewSlot> Atlas::references(CellId cell) const {
  const std::scoped_lock lock(mutex_);
  require_cell(cell);
  return *references_[cell];
}

void Atlas::mark_seen(std::span<const CellPixels> cells) {
  AtlasEdit edit;
  edit.mark_seen(cells);
  commit(std::move(edit));
}

// Checks all that needs no look at the store before it takes the lock.
void Atlas::commit(AtlasEdit edit) {
  for (const AtlasEdit::Change& change : edit.changes_) check_change(change, layout_);
  std::size_t applied = 0;
  const std::scoped_lock lock(mutex_);  // what the edit takes out of the store is freed after it
  try {
    for (; applied < edit.changes_.size(); ++applied) {
      std::visit([this](auto& change) { apply(change); }, edit.changes_[applied]);
    }
  } catch (...) {
    while (applied > 0) std::visit([this](auto& change) { take_back(change); }, edit.changes_[--applied]);
    throw;
  }
}

// These functions change nothing where they throw. Each leaves in the change what was there before.
void Atlas::apply(AtlasEdit::ViewChange& change) {
  const ViewSlot slot = change.slot;
  if (change.kind == AtlasEdit::ViewChange::Kind::insert) {
    require_slot(slot);
    if (views_[slot]) throw std::logic_error("atlas: slot " + std::to_string(slot) + " holds a view already");
  } else {
    require_stored(slot);
  }
  if (change.kind == AtlasEdit::ViewChange::Kind::erase) {
    if (references_to_slot_[slot] != 0) {
      throw std::logic_error("atlas: erase of slot " + std::to_string(slot) + ", which " +
                             std::to_string(references_to_slot_[slot]) + " cells refer to");
    }
    change.shown = nothing_shown();
  } else {
    require_cells_of(change.view->name, *change.shown);
  }
  change.tenant = change.kind == AtlasEdit::ViewChange::Kind::insert ? ++inserted_ : tenants_[slot];
  if (change.kind != AtlasEdit::ViewChange::Kind::erase) change.gain = gains_[slot];
  take_back(change);
}

void Atlas::take_back(AtlasEdit::ViewChange& change) noexcept {
  views_[change.slot].swap(change.view);
  shown_[change.slot].swap(change.shown);
  std::swap(gains_[change.slot], change.gain);
  std::swap(tenants_[change.slot], change.tenant);
}

void Atlas::apply(AtlasEdit::GainChange& change) {
  require_stored(change.slot);
  take_back(change);
}

void Atlas::take_back(AtlasEdit::GainChange& change) noexcept {
  std::swap(gains_[change.slot], change.gain);
}

void Atlas::apply(AtlasEdit::ReferencesChange& change) {
  require_cell(change.cell);
  for (const ViewSlot slot : *change.slots) require_stored(slot);
  take_back(change);
}

void Atlas::take_back(AtlasEdit::ReferencesChange& change) noexcept {
  if (*references_[change.cell] == *change.slots) return;
  for (const ViewSlot slot : *references_[change.cell]) --references_to_slot_[slot];
  for (const ViewSlot slot : *change.slots) ++references_to_slot_[slot];
  references_[change.cell].swap(change.slots);
  mark_changed(change.cell);
}

void Atlas::apply(AtlasEdit::SeenChange& change) {
  for (const CellId cell : change.cells) require_cell(cell);
  for (const CellId cell : change.cells) {
    if (std::exchange(cell_seen_[cell], std::uint8_t{1}) != 0) continue;
    newly_seen_.push_back(cell);
    ++change.new_cells;
  }
}

void Atlas::take_back(AtlasEdit::SeenChange& change) noexcept {
  for (; change.new_cells > 0; --change.new_cells) {
    cell_seen_[newly_seen_.back()] = 0;
    newly_seen_.pop_back();
  }
}

std::pair<std::size_t, std::vector<SharedShownCells>> Atlas::shown_of_cells() const {
  const std::scoped_lock lock(mutex_);
  return {references_.size(), shown_};
}

// The store's values of each cell.
struct Atlas::ByCell {
  std::vector<SharedSlots> references;
  std::vector<std::uint8_t> seen, changed;
  std::vector<std::uint32_t> references_to_slot;
  std::vector<CellId> changed_cells, newly_seen;
};

// References and what was seen go where their cells went.
Atlas::ByCell Atlas::by_cell(std::span<const CellId> previous_cell) const {
  const std::size_t cells = previous_cell.size();
  ByCell now;
  now.references.assign(cells, no_slots());
  now.seen.assign(cells, 0);
  now.changed.assign(cells, 0);
  now.references_to_slot.assign(views_.size(), 0);
  now.changed_cells.reserve(cells);
  now.newly_seen.reserve(cells);
  for (std::size_t cell = 0; cell < cells; ++cell) {
    if (previous_cell[cell] == CellId::none) continue;
    now.references[cell] = references_[previous_cell[cell]];
    now.seen[cell] = cell_seen_[previous_cell[cell]];
    for (const ViewSlot slot : *now.references[cell]) ++now.references_to_slot[slot];
  }
  return now;
}

// Renumbers the cells that tiles show without the lock, then once more for the views that other threads have changed
// meanwhile, and under the lock for the few that they have changed since. So no writer can put the surface off.
void Atlas::replace_surface(std::shared_ptr<const Surface> surface, std::span<const CellId> previous_cell,
                            std::span<const ViewPose> poses) {
  const std::size_t cells = checked(surface).cells.cells.size();
  check_poses(poses);
  const std::vector<std::shared_ptr<const StoredView>> before = stored_at(poses);
  std::vector<std::shared_ptr<const StoredView>> after = moved_views(before, poses);  // in the end the old ones
  for (;;) {
    const auto [cells_before, shown] = shown_of_cells();
    require_previous_cells(previous_cell, cells, cells_before);
    RenumberedTiles tiles(cells_that_were(previous_cell, cells_before));
    tiles.follow(shown);
    const auto [cells_meanwhile, shown_meanwhile] = shown_of_cells();
    if (cells_meanwhile != cells_before) continue;  // another thread has replaced the surface
    tiles.follow(shown_meanwhile);
    const std::scoped_lock lock(mutex_);
    if (references_.size() != cells_before) continue;
    if (surface->offset != surface_->offset) {
      throw std::invalid_argument("atlas: the new surface has another offset than the one before, must have the same");
    }
    tiles.follow(shown_);
    ByCell now = by_cell(previous_cell);
    keep_up(poses, before, after);
    // The code from here on must not fail.
    swap_views(poses, after);
    shown_.swap(tiles.now());
    surface_.swap(surface);  // the old surface is freed after the lock
    references_.swap(now.references);
    references_to_slot_.swap(now.references_to_slot);
    cell_seen_.swap(now.seen);
    cell_changed_.swap(now.changed);
    changed_cells_.swap(now.changed_cells);
    newly_seen_.swap(now.newly_seen);
    all_changed_ = true;
    return;
  }
}

void Atlas::choose_tiles_anew() {
  const std::scoped_lock lock(mutex_);
  choose_tiles_anew_ = true;
}

void Atlas::set_tile_limit(std::uint32_t max_tiles) {
  const std::unique_lock one_at_a_time = one_snapshot_at_a_time();
  if (maker_) maker_->set_tile_limit(max_tiles);
  layout_.max_tiles = max_tiles;
}

std::vector<SharedShownCells> Atlas::retile(const TileOptions& layout, std::vector<SharedShownCells> shown) {
  lumatlas::check(layout);
  const std::unique_lock one_at_a_time = one_snapshot_at_a_time();
  const std::scoped_lock lock(mutex_);
  if (shown.size() != views_.size()) {
    throw std::invalid_argument("atlas: shown has " + std::to_string(shown.size()) +
                                " entries, must have one per slot, " + std::to_string(views_.size()));
  }
  for (std::size_t slot = 0; slot < shown.size(); ++slot) {
    if (!shown[slot]) throw std::invalid_argument("atlas: shown[" + std::to_string(slot) + "] is null");
    if (views_[slot]) {
      require_shown_cells_of(views_[slot]->name, views_[slot]->camera, *shown[slot], layout);
      require_cells_of(views_[slot]->name, *shown[slot]);
    } else if (!shown[slot]->empty()) {
      throw std::invalid_argument("atlas: shown[" + std::to_string(slot) + "] is not empty, its slot holds no view");
    }
  }
  layout_ = layout;
  shown_.swap(shown);
  maker_.reset();
  mark_all_changed();
  return shown;
}

void Atlas::mark_changed(CellId cell) {
  if (std::exchange(cell_changed_[cell], std::uint8_t{1}) == 0) changed_cells_.push_back(cell);
}

void Atlas::mark_all_changed() const {
  all_changed_ = true;
  changed_cells_.clear();
  newly_seen_.clear();
  cell_changed_.assign(references_.size(), 0);
}

// Copies pointers, gains, and the references of the cells whose references have changed.
StoreChanges Atlas::take_changes() const {
  StoreChanges changes;
  const std::scoped_lock lock(mutex_);
  changes.surface = surface_;
  changes.views = views_;
  changes.shown = shown_;
  changes.gains = gains_;
  changes.tenants = tenants_;
  changes.all_cells = all_changed_;
  if (all_changed_) {
    for (CellId cell{0}; cell < references_.size(); ++cell) {
      changes.references.push_back({cell, references_[cell]});
      if (cell_seen_[cell] != 0) changes.seen.push_back(cell);
    }
  } else {
    for (const CellId cell : changed_cells_) changes.references.push_back({cell, references_[cell]});
    changes.seen = newly_seen_;
  }
  changes.choose_tiles_anew = choose_tiles_anew_;
  for (const CellId cell : changed_cells_) cell_changed_[cell] = 0;
  changed_cells_.clear();
  newly_seen_.clear();
  all_changed_ = false;
  choose_tiles_anew_ = false;
  return changes;
}

// Locks snapshot_mutex_. Throws std::logic_error on a thread that is making a snapshot already, whose policy would wait
// for itself.
std::unique_lock<std::mutex> Atlas::one_snapshot_at_a_time() const {
  if (snapshot_thread_ == std::this_thread::get_id()) {
    throw std::logic_error(
        "atlas: its tile policy asks for a snapshot, or for other tiles, while it chooses those of a snapshot");
  }
  return std::unique_lock(snapshot_mutex_);
}

Snapshot Atlas::snapshot() const {
  const std::unique_lock one_at_a_time = one_snapshot_at_a_time();
  const NotedThread noted(snapshot_thread_);  // ends before the lock does
  try {
    if (!maker_) maker_ = std::make_unique<SnapshotMaker>(layout_, policy_);
    Snapshot snapshot;
    // Isolated, so that this thread, where it waits for others, does not begin another task of the caller's, which may
    // ask for a snapshot, too.
    tbb::this_task_arena::isolate([&] { snapshot = maker_->snapshot(take_changes()); });
    return snapshot;
  } catch (...) {
    maker_.reset();  // it may have taken half of the changes: the next one starts with all
    const std::scoped_lock lock(mutex_);
    mark_all_changed();
    throw;
  }
}

void Atlas::require_cell(CellId cell) const {
  if (cell < references_.size()) return;
  throw std::invalid_argument("atlas: cell is " + std::to_string(cell) + ", must be below the number of cells, " +
                              std::to_string(references_.size()));
}

void Atlas::require_cells_of(const std::string& view, std::span<const ShownCell> shown) const {
  for (std::size_t i = 0; i < shown.size(); ++i) {
    if (shown[i].cell < references_.size()) continue;
    throw std::invalid_argument("view " + view + ": shown[" + std::to_string(i) + "] is of cell " +
                                std::to_string(shown[i].cell) + ", must be below the number of cells, " +
                                std::to_string(references_.size()) + ": was it made for another surface?");
  }
}

void Atlas::require_slot(ViewSlot slot) const {
  if (slot < views_.size()) return;
  throw std::invalid_argument("atlas: slot is " + std::to_string(slot) + ", must be below the capacity, " +
                              std::to_string(views_.size()));
}

void Atlas::require_stored(ViewSlot slot) const {
  if (slot >= views_.size() || !views_[slot]) {
    throw std::logic_error("atlas: slot " + std::to_string(slot) + " holds no view");
  }
}

}  // namespace lumatlas
