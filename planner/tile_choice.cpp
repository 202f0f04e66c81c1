// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/tile_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <queue>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

namespace lumatlas {

namespace {

constexpr float kLambda = 0.8f;
constexpr double kWidthDegrees = 30;
constexpr std::size_t kBlended = 3;
constexpr std::array<float, kBlended> kRankValue{4.0f / 7, 2.0f / 7, 1.0f / 7};
constexpr double kUntrimmed = 1.2;  // tiles of whole views, per tile that there may be

// Share of the tiles that may be exchanged for others when a choice is brought up to date.
constexpr double kExchanged = 0.1;
// An exchange must add this much more than it removes: less is rounding, and would be undone by the next one.
constexpr double kLeastAdvantage = 1.001;

// A view that shows a cell.
struct ShowingView {
  ViewSlot view;
  std::uint32_t pixels = 0;    // the cell's pixels in it
  std::uint32_t resident = 0;  // how many of these are in resident tiles
  bool referred = false;       // the cell refers to the view
  glm::vec3 direction{0};      // unit, from the cell
  float resolution = 0;        // pixels per length
};

// The best K + 1 views that serve a direction of a cell, best first.
struct Served {
  struct By {
    float quality = 0;
    std::uint32_t number = ~0u;  // the view's, among those that show the cell
  };
  std::array<By, kBlended + 1> best;
};

struct CellState {
  std::vector<ShowingView> views;  // that show it, ascending
  std::vector<Served> served;      // one for each of those views' directions
  std::size_t referred = 0;        // views that the cell refers to
  std::size_t most = 0;            // to how many it may
};

// A part of a cell, as a tile or a whole view shows it.
struct Part {
  std::uint32_t cell;
  std::uint32_t view;  // its number among the views that show the cell
  std::uint32_t pixels;
};

// Parts that come together.
struct Range {
  std::uint32_t first, end;
};

// The value of a part, valid until its cell has changed again.
struct Known {
  double value = 0;
  std::uint32_t changes = ~0u;
};

struct TileCandidate {
  ViewTile tile;
  Range parts;
};

// That a tile shows a part of a cell.
struct TileOfCell {
  std::uint32_t view;  // its number among the views that show the cell
  std::uint32_t candidate;
};

struct WholeView {
  Range tiles;  // candidates
  Range parts;  // one for each cell
};

// Numbers by falling value. Values may fall at any time: each is worked out again at the head of the queue. A number
// whose value may have risen must be put in again.
class LazyQueue {
 public:
  LazyQueue(std::size_t numbers, std::function<double(std::uint32_t)> value)
      : value_(std::move(value)), newest_(numbers, 0) {}

  struct Top {
    std::uint32_t number;
    double value;
  };

  void put(std::uint32_t number) { push(number, value_(number)); }
  // Takes the number of the most value out, of equals the least one; none: there is no number left.
  [[nodiscard]] std::optional<Top> take() {
    while (!queue_.empty()) {
      const Entry entry = queue_.top();
      queue_.pop();
      const auto number = static_cast<std::uint32_t>(-std::get<1>(entry));
      if (std::get<2>(entry) != newest_[number]) continue;  // it was put in again later
      const double value = value_(number);
      const Entry now(value, std::get<1>(entry), std::numeric_limits<std::uint32_t>::max());
      if (queue_.empty() || now >= queue_.top()) return Top{number, value};
      push(number, value);
    }
    return std::nullopt;
  }

 private:
  using Entry = std::tuple<double, std::int64_t, std::uint32_t>;  // value, negative number, which one of that number

  void push(std::uint32_t number, double value) { queue_.emplace(value, -std::int64_t{number}, ++newest_[number]); }

  std::function<double(std::uint32_t)> value_;
  std::vector<std::uint32_t> newest_;  // for each number, its last entry
  std::priority_queue<Entry> queue_;
};

class Chooser {
 public:
  explicit Chooser(const TileDemand& demand);

  [[nodiscard]] TileChoice chosen_from_all(std::size_t count);
  // Goes on from these tiles, as far as they are there.
  [[nodiscard]] TileChoice brought_up_to_date(std::span<const ViewTile> resident, std::size_t count);

 private:
  void add_views(ViewSlot view, std::span<const ShownCell> shown);
  void measure_views(const TileDemand& demand);
  void add_candidates(ViewSlot view, std::span<const ShownCell> shown);
  void add_whole_view(std::uint32_t first_tile);
  void list_tiles_of_cells();
  [[nodiscard]] double gain(const Range& parts);
  [[nodiscard]] double gain(const Part& part) const;
  [[nodiscard]] double loss(const Range& parts);
  [[nodiscard]] double loss(const Part& part) const;
  [[nodiscard]] double loss_with_successor(const Part& part) const;
  void take(std::uint32_t candidate);
  void take(const Part& part);
  void give_up(std::uint32_t candidate);
  void give_up(const Part& part);
  [[nodiscard]] bool is_last(const Part& part) const;
  void put_once(std::vector<std::uint32_t>& numbers, bool taken, LazyQueue& queue) const;
  void add_neighbours(std::uint32_t candidate, const Part& part, bool of_all_views,
                      std::vector<std::uint32_t>& neighbours) const;
  [[nodiscard]] double worth() const;
  void take_whole_views(std::size_t count);
  void trim(std::size_t count);
  void fill(std::size_t count);
  void exchange(std::size_t most);
  [[nodiscard]] TileChoice choice() const;

  std::vector<CellState> cells_;
  std::vector<Part> parts_;
  std::vector<TileCandidate> candidates_;  // ascending by view, then by tile
  std::vector<WholeView> whole_views_;
  std::vector<std::uint32_t> first_tile_of_cell_;  // one more than there are cells
  std::vector<TileOfCell> tiles_of_cells_;         // for each cell ascending by candidate, and so by view
  std::vector<std::uint32_t> changes_;             // one per cell: how often it has changed
  std::vector<Known> gains_, losses_;              // one per part
  std::vector<std::uint8_t> taken_;                // one per candidate
  std::size_t taken_count_ = 0;
};

// Returns the quality with `resident` pixels of the cell in resident tiles.
float quality(const ShowingView& by, const ShowingView& asked, std::uint32_t resident) {
  static const auto kScale = static_cast<float>(1 / (1 - std::cos(glm::radians(kWidthDegrees))));
  const float k = std::clamp(1 - (1 - glm::dot(by.direction, asked.direction)) * kScale, 0.0f, 1.0f);
  const float resolution = std::min(1.0f, by.resolution / asked.resolution);
  const float share = static_cast<float>(resident) / static_cast<float>(by.pixels);
  return share * resolution * (kLambda * k + 1 - kLambda);
}

// The best of a direction, once a view has another quality. Right where that is better than before; where it is worse,
// one that was not among the best may have to take its place, and is missing.
Served with(const Served& served, std::uint32_t number, float quality) {
  Served result;
  std::size_t next = 0;
  Served::By newcomer{quality, number};
  for (const Served::By& by : served.best) {
    if (by.number == number) continue;
    if (newcomer.quality > by.quality && next < result.best.size()) {
      result.best[next++] = newcomer;
      newcomer.quality = -1;
    }
    if (next < result.best.size()) result.best[next++] = by;
  }
  return result;
}

float worth_of(const Served& served) {
  float sum = 0;
  for (std::size_t rank = 0; rank < kBlended; ++rank) sum += kRankValue[rank] * served.best[rank].quality;
  return sum;
}

bool serves(const Served& served, std::uint32_t number) {
  return std::any_of(served.best.begin(), served.best.end(),
                     [number](const Served::By& by) { return by.number == number; });
}

// Returns the best of all views that the cell refers to.
Served best_of(const CellState& state, const ShowingView& asked) {
  Served served;
  for (std::uint32_t number = 0; number < state.views.size(); ++number) {
    const ShowingView& other = state.views[number];
    if (other.referred) served = with(served, number, quality(other, asked, other.resident));
  }
  return served;
}

double worth_of(const CellState& state) {
  double sum = 0;
  for (std::size_t asked = 0; asked < state.views.size(); ++asked) {
    sum += static_cast<double>(state.views[asked].pixels) * static_cast<double>(worth_of(state.served[asked]));
  }
  return sum;
}

// The view that a cell would refer to next if there were room: of those that it does not refer to, the one that shows
// most of it in resident tiles.
std::optional<std::uint32_t> successor(const CellState& state, std::uint32_t leaving) {
  std::optional<std::uint32_t> next;
  for (std::uint32_t number = 0; number < state.views.size(); ++number) {
    const ShowingView& view = state.views[number];
    if (view.referred || number == leaving || view.resident == 0) continue;
    if (!next || view.resident > state.views[*next].resident) next = number;
  }
  return next;
}

// If the cell refers to the view already, its quality can only have become better.
void refer(CellState& state, std::uint32_t number) {
  ShowingView& by = state.views[number];
  if (!by.referred) ++state.referred;
  by.referred = true;
  for (std::size_t asked = 0; asked < state.views.size(); ++asked) {
    state.served[asked] = with(state.served[asked], number, quality(by, state.views[asked], by.resident));
  }
}

// A view that the cell can no longer refer to makes room for its successor. Only the directions that it served must be
// served anew.
void shrink(CellState& state, std::uint32_t number, std::uint32_t pixels) {
  ShowingView& by = state.views[number];
  by.resident -= pixels;
  if (!by.referred) return;
  if (by.resident == 0) {
    by.referred = false;
    --state.referred;
  }
  for (std::size_t asked = 0; asked < state.views.size(); ++asked) {
    if (serves(state.served[asked], number)) state.served[asked] = best_of(state, state.views[asked]);
  }
  if (by.referred) return;
  if (const auto next = successor(state, number)) refer(state, *next);
}

void check(const TileDemand& demand) {
  const auto refuse = [](const std::string& why) { throw std::invalid_argument("tile choice: " + why); };
  const std::size_t cells = demand.surface.cells.cells.size();
  if (demand.views.size() != demand.shown.size()) {
    refuse("shown is of " + std::to_string(demand.shown.size()) + " slots, must be of as many as there are views, " +
           std::to_string(demand.views.size()));
  }
  if (demand.references.offsets.size() != cells + 1) {
    refuse("references are of " + std::to_string(demand.references.offsets.size() - 1) +
           " cells, must be of as many as the surface has, " + std::to_string(cells));
  }
  for (std::size_t slot = 0; slot < demand.views.size(); ++slot) {
    const std::string where = "slot " + std::to_string(slot);
    if (!demand.shown[slot]) refuse(where + " has no list of shown cells, must have one, empty or not");
    if (!demand.views[slot] && !demand.shown[slot]->empty()) refuse(where + " shows cells, but holds no view");
    for (const ShownCell& part : *demand.shown[slot]) {
      if (part.cell >= cells) {
        refuse(where + " shows cell " + std::to_string(part.cell) + ", must be below " + std::to_string(cells));
      }
    }
  }
}

Chooser::Chooser(const TileDemand& demand) : cells_(demand.surface.cells.cells.size()) {
  check(demand);
  for (ViewSlot slot{0}; slot < demand.shown.size(); ++slot) add_views(slot, *demand.shown[slot]);
  measure_views(demand);
  for (ViewSlot slot{0}; slot < demand.shown.size(); ++slot) {
    const auto first = static_cast<std::uint32_t>(candidates_.size());
    add_candidates(slot, *demand.shown[slot]);
    add_whole_view(first);
  }
  list_tiles_of_cells();
  changes_.resize(cells_.size(), 0);
  gains_.resize(parts_.size());
  losses_.resize(parts_.size());
  taken_.resize(candidates_.size(), 0);
}

void Chooser::add_views(ViewSlot view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    std::vector<ShowingView>& views = cells_[part.cell].views;
    if (views.empty() || views.back().view != view) views.push_back({view});
    views.back().pixels += part.pixels;
  }
}

void Chooser::measure_views(const TileDemand& demand) {
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    CellState& state = cells_[cell];
    state.most = demand.references.of_cell(cell).size();
    state.served.resize(state.views.size());
    for (ShowingView& view : state.views) {
      const Camera& camera = demand.views[view.view]->camera;
      const glm::dvec3 towards = camera.center() - demand.surface.cells.cells[cell].centroid;
      const double distance = std::max(glm::length(towards), 1e-300);
      view.direction = glm::vec3(towards / distance);
      view.resolution = static_cast<float>(std::min(camera.fx / distance, 1e30));
    }
  }
}

// Tiles whose gutter alone shows something are none: their neighbours hold the same pixels.
void Chooser::add_candidates(ViewSlot view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    if (part.pixels == 0) continue;
    const bool known =
        !candidates_.empty() && candidates_.back().tile.view == view && candidates_.back().tile.tile == part.tile;
    if (!known) {
      const auto first = static_cast<std::uint32_t>(parts_.size());
      candidates_.push_back({{view, part.tile}, {first, first}});
    }
    const std::vector<ShowingView>& views = cells_[part.cell].views;
    const auto found = std::lower_bound(views.begin(), views.end(), view,
                                        [](const ShowingView& showing, ViewSlot v) { return showing.view < v; });
    parts_.push_back({part.cell, static_cast<std::uint32_t>(found - views.begin()), part.pixels});
    candidates_.back().parts.end = static_cast<std::uint32_t>(parts_.size());
  }
}

void Chooser::add_whole_view(std::uint32_t first_tile) {
  if (first_tile == candidates_.size()) return;
  const auto first = static_cast<std::uint32_t>(parts_.size());
  std::vector<Part> parts(parts_.begin() + candidates_[first_tile].parts.first, parts_.end());
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.cell < b.cell; });
  for (const Part& part : parts) {
    if (parts_.size() > first && parts_.back().cell == part.cell) {
      parts_.back().pixels += part.pixels;
    } else {
      parts_.push_back(part);
    }
  }
  whole_views_.push_back({{first_tile, static_cast<std::uint32_t>(candidates_.size())},
                          {first, static_cast<std::uint32_t>(parts_.size())}});
}

void Chooser::list_tiles_of_cells() {
  first_tile_of_cell_.assign(cells_.size() + 1, 0);
  for (const TileCandidate& candidate : candidates_) {
    for (std::uint32_t part = candidate.parts.first; part < candidate.parts.end; ++part) {
      ++first_tile_of_cell_[parts_[part].cell + 1];
    }
  }
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) first_tile_of_cell_[cell + 1] += first_tile_of_cell_[cell];
  tiles_of_cells_.resize(first_tile_of_cell_.back());
  std::vector<std::uint32_t> next(first_tile_of_cell_.begin(), first_tile_of_cell_.end() - 1);
  for (std::uint32_t number = 0; number < candidates_.size(); ++number) {
    const Range& parts = candidates_[number].parts;
    for (std::uint32_t part = parts.first; part < parts.end; ++part) {
      tiles_of_cells_[next[parts_[part].cell]++] = {parts_[part].view, number};
    }
  }
}

// Other tiles of the same view that show a part of the cell, or those of all views.
void Chooser::add_neighbours(std::uint32_t candidate, const Part& part, bool of_all_views,
                             std::vector<std::uint32_t>& neighbours) const {
  for (std::uint32_t i = first_tile_of_cell_[part.cell]; i < first_tile_of_cell_[part.cell + 1]; ++i) {
    const TileOfCell& tile = tiles_of_cells_[i];
    if (tile.candidate != candidate && (of_all_views || tile.view == part.view)) neighbours.push_back(tile.candidate);
  }
}

// Returns whether the view has nothing else of the cell.
bool Chooser::is_last(const Part& part) const {
  return cells_[part.cell].views[part.view].resident == part.pixels;
}

double Chooser::gain(const Part& part) const {
  const CellState& state = cells_[part.cell];
  const ShowingView& by = state.views[part.view];
  if (!by.referred && state.referred >= state.most) return 0;
  double sum = 0;
  for (std::size_t asked = 0; asked < state.views.size(); ++asked) {
    const float q = quality(by, state.views[asked], by.resident + part.pixels);
    const Served& served = state.served[asked];
    if (q <= served.best[kBlended - 1].quality) continue;
    sum += static_cast<double>(state.views[asked].pixels) *
           static_cast<double>(worth_of(with(served, part.view, q)) - worth_of(served));
  }
  return sum;
}

double Chooser::gain(const Range& parts) {
  double sum = 0;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) {
    const std::uint32_t changes = changes_[parts_[part].cell];
    if (gains_[part].changes != changes) gains_[part] = {gain(parts_[part]), changes};
    sum += gains_[part].value;
  }
  return sum;
}

// Returns the loss for a cell that goes on to refer to the view, or that has no other view to replace it.
double Chooser::loss(const Part& part) const {
  const CellState& state = cells_[part.cell];
  const ShowingView& by = state.views[part.view];
  if (!by.referred) return 0;
  if (is_last(part) && successor(state, part.view)) return loss_with_successor(part);
  double sum = 0;
  for (std::size_t asked = 0; asked < state.views.size(); ++asked) {
    const Served& served = state.served[asked];
    const auto end = served.best.begin() + kBlended;
    if (std::none_of(served.best.begin(), end, [&](const Served::By& b) { return b.number == part.view; })) continue;
    const float q = quality(by, state.views[asked], by.resident - part.pixels);
    sum += static_cast<double>(state.views[asked].pixels) *
           static_cast<double>(worth_of(served) - worth_of(with(served, part.view, q)));
  }
  return sum;
}

double Chooser::loss_with_successor(const Part& part) const {
  CellState without = cells_[part.cell];
  shrink(without, part.view, part.pixels);
  return worth_of(cells_[part.cell]) - worth_of(without);
}

double Chooser::loss(const Range& parts) {
  double sum = 0;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) {
    const std::uint32_t changes = changes_[parts_[part].cell];
    if (losses_[part].changes != changes) losses_[part] = {loss(parts_[part]), changes};
    sum += losses_[part].value;
  }
  return sum;
}

void Chooser::take(const Part& part) {
  CellState& state = cells_[part.cell];
  ShowingView& by = state.views[part.view];
  by.resident += part.pixels;
  ++changes_[part.cell];
  if (by.referred || state.referred < state.most) refer(state, part.view);
}

void Chooser::take(std::uint32_t candidate) {
  const Range& parts = candidates_[candidate].parts;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) take(parts_[part]);
  taken_[candidate] = 1;
  ++taken_count_;
}

void Chooser::give_up(const Part& part) {
  ++changes_[part.cell];
  shrink(cells_[part.cell], part.view, part.pixels);
}

void Chooser::give_up(std::uint32_t candidate) {
  const Range& parts = candidates_[candidate].parts;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) give_up(parts_[part]);
  taken_[candidate] = 0;
  --taken_count_;
}

double Chooser::worth() const {
  double sum = 0;
  for (const CellState& state : cells_) sum += worth_of(state);
  return sum;
}

// Takes views by their gain per tile until one does not fit. The gain of a whole view only falls while others are
// taken.
void Chooser::take_whole_views(std::size_t count) {
  LazyQueue queue(whole_views_.size(), [this](std::uint32_t number) {
    const WholeView& view = whole_views_[number];
    return gain(view.parts) / static_cast<double>(view.tiles.end - view.tiles.first);
  });
  for (std::uint32_t number = 0; number < whole_views_.size(); ++number) {
    if (taken_[whole_views_[number].tiles.first] == 0) queue.put(number);
  }
  while (const auto top = queue.take()) {
    const WholeView& view = whole_views_[top->number];
    const std::size_t tiles = view.tiles.end - view.tiles.first;
    if (!(top->value > 0) || taken_count_ + tiles > count) return;
    for (std::uint32_t part = view.parts.first; part < view.parts.end; ++part) take(parts_[part]);
    std::fill(taken_.begin() + view.tiles.first, taken_.begin() + view.tiles.end, std::uint8_t{1});
    taken_count_ += tiles;
  }
}

// Puts each of these tiles into the queue once, if it is taken, or if it is not.
void Chooser::put_once(std::vector<std::uint32_t>& numbers, bool taken, LazyQueue& queue) const {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  for (const std::uint32_t number : numbers) {
    if ((taken_[number] != 0) == taken) queue.put(number);
  }
}

// Gives up the tiles of the least loss. If a view has less of a cell, the rest of it is missed less. If a view's last
// part of a cell goes, another may take its place, and all views that serve the cell are missed less. All others are
// missed more, with one exception: a view whose place another would take is missed a little less where that one has
// become better beside others.
void Chooser::trim(std::size_t count) {
  LazyQueue queue(candidates_.size(), [this](std::uint32_t tile) { return -loss(candidates_[tile].parts); });
  for (std::uint32_t tile = 0; tile < candidates_.size(); ++tile) {
    if (taken_[tile] != 0) queue.put(tile);
  }
  std::vector<std::uint32_t> neighbours;
  while (taken_count_ > count) {
    const std::uint32_t tile = queue.take()->number;
    const Range& parts = candidates_[tile].parts;
    neighbours.clear();
    for (std::uint32_t part = parts.first; part < parts.end; ++part) {
      add_neighbours(tile, parts_[part], is_last(parts_[part]), neighbours);
    }
    give_up(tile);
    put_once(neighbours, true, queue);
  }
}

// Takes the tiles that add most. Where a view has more of a cell, the rest of it adds more, for it serves better than
// others who would have come first; all others only add less.
void Chooser::fill(std::size_t count) {
  LazyQueue queue(candidates_.size(), [this](std::uint32_t tile) { return gain(candidates_[tile].parts); });
  for (std::uint32_t tile = 0; tile < candidates_.size() && taken_count_ < count; ++tile) {
    if (taken_[tile] == 0) queue.put(tile);
  }
  std::vector<std::uint32_t> neighbours;
  while (taken_count_ < count) {
    const auto top = queue.take();
    if (!top || !(top->value > 0)) return;
    take(top->number);
    neighbours.clear();
    const Range& parts = candidates_[top->number].parts;
    for (std::uint32_t part = parts.first; part < parts.end; ++part) {
      add_neighbours(top->number, parts_[part], false, neighbours);
    }
    put_once(neighbours, false, queue);
  }
}

// Up to `most` resident tiles for others, where that makes the sum more. The order is that of one look at all of them,
// so what an exchange is worth is found by making it.
void Chooser::exchange(std::size_t most) {
  std::vector<std::pair<double, std::uint32_t>> inside, outside;
  for (std::uint32_t tile = 0; tile < candidates_.size(); ++tile) {
    if (taken_[tile] != 0) {
      inside.emplace_back(loss(candidates_[tile].parts), tile);
    } else if (const double added = gain(candidates_[tile].parts); added > 0) {
      outside.emplace_back(-added, tile);
    }
  }
  std::sort(inside.begin(), inside.end());
  std::sort(outside.begin(), outside.end());
  const std::size_t pairs = std::min({most, inside.size(), outside.size()});
  for (std::size_t i = 0; i < pairs && -outside[i].first > kLeastAdvantage * inside[i].first; ++i) {
    const double lost = loss(candidates_[inside[i].second].parts);
    give_up(inside[i].second);
    const bool better = gain(candidates_[outside[i].second].parts) > kLeastAdvantage * lost;
    take(better ? outside[i].second : inside[i].second);
  }
}

TileChoice Chooser::choice() const {
  TileChoice choice;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (taken_[i] != 0) choice.tiles.push_back(candidates_[i].tile);
  }
  for (const CellState& state : cells_) {
    for (const ShowingView& view : state.views) {
      if (view.referred) choice.references.views.push_back(view.view);
    }
    choice.references.offsets.push_back(static_cast<std::uint32_t>(choice.references.views.size()));
  }
  return choice;
}

TileChoice Chooser::chosen_from_all(std::size_t count) {
  take_whole_views(count);
  Chooser fitting = *this;
  take_whole_views(static_cast<std::size_t>(kUntrimmed * static_cast<double>(count)));
  trim(count);
  fill(count);
  fitting.fill(count);
  return fitting.worth() > worth() ? fitting.choice() : choice();
}

TileChoice Chooser::brought_up_to_date(std::span<const ViewTile> resident, std::size_t count) {
  const auto before = [](const TileCandidate& candidate, const ViewTile& tile) {
    return std::tie(candidate.tile.view, candidate.tile.tile) < std::tie(tile.view, tile.tile);
  };
  for (const ViewTile& tile : resident) {
    const auto found = std::lower_bound(candidates_.begin(), candidates_.end(), tile, before);
    const bool there = found != candidates_.end() && found->tile.view == tile.view && found->tile.tile == tile.tile;
    const auto number = static_cast<std::uint32_t>(found - candidates_.begin());
    if (there && taken_[number] == 0) take(number);
  }
  trim(count);
  fill(count);
  exchange(static_cast<std::size_t>(std::ceil(kExchanged * static_cast<double>(count))));
  return choice();
}

}  // namespace

TileChoice choose_tiles(const TileDemand& demand) {
  Chooser chooser(demand);
  return demand.resident.empty() ? chooser.chosen_from_all(demand.max_tiles)
                                 : chooser.brought_up_to_date(demand.resident, demand.max_tiles);
}

}  // namespace lumatlas
