// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tile_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <queue>
#include <tuple>
#include <utility>

namespace lumatlas {

namespace {

constexpr float kLambda = 0.8f;
constexpr double kWidthDegrees = 30;
constexpr std::size_t kBlended = 3;
constexpr std::array<float, kBlended> kRankValue{4.0f / 7, 2.0f / 7, 1.0f / 7};
constexpr double kUntrimmed = 1.2;  // tiles of whole views, per tile that there may be

// A view that sees a cell.
struct Seer {
  std::uint32_t view;
  std::uint32_t pixels = 0;    // of the cell in it
  std::uint32_t resident = 0;  // of these, in resident tiles
  bool referred = false;       // whether the cell refers to the view
  glm::vec3 direction{0};      // unit, from the cell
  float resolution = 0;        // pixels per length
};

// The best K + 1 seers that serve a direction of a cell, best first.
struct Served {
  struct By {
    float quality = 0;
    std::uint32_t seer = ~0u;
  };
  std::array<By, kBlended + 1> best;
};

struct CellState {
  std::vector<Seer> seers;     // by ascending view
  std::vector<Served> served;  // by seer: the direction that it stands for
  std::size_t referred = 0;    // seers that are
  std::size_t most = 0;        // of those
};

// A part of a cell, as a tile or a whole view shows it.
struct Part {
  std::uint32_t cell;
  std::uint32_t seer;
  std::uint32_t pixels;
};

// Parts that come together.
struct Range {
  std::uint32_t first, end;
};

struct Candidate {
  ViewTile tile;
  Range parts;
};

struct WholeView {
  Range tiles;  // candidates
  Range parts;  // one for each cell
};

// Numbers by falling value, where values only fall while others are taken out: each is worked out anew at the top only.
class LazyQueue {
 public:
  explicit LazyQueue(std::function<double(std::uint32_t)> value) : value_(std::move(value)) {}

  struct Top {
    std::uint32_t number;
    double value;
  };

  void add(std::uint32_t number) { queue_.emplace(value_(number), -std::int64_t{number}); }
  // The number of the most value, of equals the least one; none: there is no number left.
  [[nodiscard]] std::optional<Top> take() {
    while (!queue_.empty()) {
      const std::int64_t negative = std::get<1>(queue_.top());
      queue_.pop();
      const auto number = static_cast<std::uint32_t>(-negative);
      const Entry now(value_(number), negative);
      if (queue_.empty() || now >= queue_.top()) return Top{number, std::get<0>(now)};
      queue_.push(now);
    }
    return std::nullopt;
  }

 private:
  using Entry = std::tuple<double, std::int64_t>;  // value, negative number

  std::function<double(std::uint32_t)> value_;
  std::priority_queue<Entry> queue_;
};

class TileChoice {
 public:
  TileChoice(std::span<const std::shared_ptr<const StoredView>> views, const Cells& cells,
             std::span<const std::vector<ShownCell>> shown, const ReferenceTable& references);

  [[nodiscard]] std::vector<ViewTile> choose(std::size_t count);
  [[nodiscard]] ReferenceTable references() const;

 private:
  void add_seers(std::uint32_t view, std::span<const ShownCell> shown);
  void add_candidates(std::uint32_t view, std::span<const ShownCell> shown);
  void add_whole_view(std::uint32_t first_tile);
  [[nodiscard]] double gain(const Range& parts) const;
  [[nodiscard]] double gain(const Part& part) const;
  [[nodiscard]] double loss(const Range& parts) const;
  [[nodiscard]] double loss(const Part& part) const;
  void take(const Part& part);
  void give_up(const Part& part);
  [[nodiscard]] double worth() const;
  void take_whole_views(std::size_t count);
  void trim(std::size_t count);
  void fill(std::size_t count);

  std::vector<CellState> cells_;
  std::vector<Part> parts_;
  std::vector<Candidate> candidates_;
  std::vector<WholeView> whole_views_;
  std::vector<std::uint8_t> taken_;  // by candidate
  std::size_t taken_count_ = 0;
};

// With so many pixels of the cell in resident tiles.
float quality(const Seer& by, const Seer& asked, std::uint32_t resident) {
  static const auto kScale = static_cast<float>(1 / (1 - std::cos(glm::radians(kWidthDegrees))));
  const float k = std::clamp(1 - (1 - glm::dot(by.direction, asked.direction)) * kScale, 0.0f, 1.0f);
  const float resolution = std::min(1.0f, by.resolution / asked.resolution);
  const float share = static_cast<float>(resident) / static_cast<float>(by.pixels);
  return share * resolution * (kLambda * k + 1 - kLambda);
}

// What a direction is worth, with a better quality of one seer.
Served with(const Served& served, std::uint32_t seer, float quality) {
  Served result;
  std::size_t next = 0;
  Served::By newcomer{quality, seer};
  for (const Served::By& by : served.best) {
    if (by.seer == seer) continue;
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

TileChoice::TileChoice(std::span<const std::shared_ptr<const StoredView>> views, const Cells& cells,
                       std::span<const std::vector<ShownCell>> shown, const ReferenceTable& references)
    : cells_(cells.cells.size()) {
  for (std::uint32_t view = 0; view < shown.size(); ++view) add_seers(view, shown[view]);
  for (std::size_t cell = 0; cell < cells_.size(); ++cell) {
    CellState& state = cells_[cell];
    state.most = references.of_cell(cell).size();
    state.served.resize(state.seers.size());
    for (Seer& seer : state.seers) {
      const Camera& camera = views[seer.view]->camera;
      const glm::dvec3 towards = camera.center() - cells.cells[cell].centroid;
      const double distance = std::max(glm::length(towards), 1e-300);
      seer.direction = glm::vec3(towards / distance);
      seer.resolution = static_cast<float>(std::min(camera.fx / distance, 1e30));
    }
  }
  for (std::uint32_t view = 0; view < shown.size(); ++view) {
    const auto first = static_cast<std::uint32_t>(candidates_.size());
    add_candidates(view, shown[view]);
    add_whole_view(first);
  }
  taken_.resize(candidates_.size(), 0);
}

void TileChoice::add_seers(std::uint32_t view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    std::vector<Seer>& seers = cells_[part.cell].seers;
    if (seers.empty() || seers.back().view != view) seers.push_back({view});
    seers.back().pixels += part.pixels;
  }
}

// Tiles whose gutter alone shows something are none: their neighbours hold the same pixels.
void TileChoice::add_candidates(std::uint32_t view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    if (part.pixels == 0) continue;
    const bool known =
        !candidates_.empty() && candidates_.back().tile.view == view && candidates_.back().tile.tile == part.tile;
    if (!known) {
      const auto first = static_cast<std::uint32_t>(parts_.size());
      candidates_.push_back({{view, part.tile}, {first, first}});
    }
    const std::vector<Seer>& seers = cells_[part.cell].seers;
    const auto seer = std::lower_bound(seers.begin(), seers.end(), view,
                                       [](const Seer& s, std::uint32_t number) { return s.view < number; });
    parts_.push_back({part.cell, static_cast<std::uint32_t>(seer - seers.begin()), part.pixels});
    candidates_.back().parts.end = static_cast<std::uint32_t>(parts_.size());
  }
}

void TileChoice::add_whole_view(std::uint32_t first_tile) {
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

double TileChoice::gain(const Part& part) const {
  const CellState& state = cells_[part.cell];
  const Seer& by = state.seers[part.seer];
  if (!by.referred && state.referred >= state.most) return 0;
  double sum = 0;
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    const float q = quality(by, state.seers[asked], by.resident + part.pixels);
    const Served& served = state.served[asked];
    if (q <= served.best[kBlended - 1].quality) continue;
    sum += static_cast<double>(state.seers[asked].pixels) *
           static_cast<double>(worth_of(with(served, part.seer, q)) - worth_of(served));
  }
  return sum;
}

double TileChoice::gain(const Range& parts) const {
  double sum = 0;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) sum += gain(parts_[part]);
  return sum;
}

double TileChoice::loss(const Part& part) const {
  const CellState& state = cells_[part.cell];
  const Seer& by = state.seers[part.seer];
  if (!by.referred) return 0;
  double sum = 0;
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    const Served& served = state.served[asked];
    const auto end = served.best.begin() + kBlended;
    if (std::none_of(served.best.begin(), end, [&](const Served::By& b) { return b.seer == part.seer; })) continue;
    const float q = quality(by, state.seers[asked], by.resident - part.pixels);
    sum += static_cast<double>(state.seers[asked].pixels) *
           static_cast<double>(worth_of(served) - worth_of(with(served, part.seer, q)));
  }
  return sum;
}

double TileChoice::loss(const Range& parts) const {
  double sum = 0;
  for (std::uint32_t part = parts.first; part < parts.end; ++part) sum += loss(parts_[part]);
  return sum;
}

void TileChoice::take(const Part& part) {
  CellState& state = cells_[part.cell];
  Seer& by = state.seers[part.seer];
  by.resident += part.pixels;
  if (!by.referred) {
    if (state.referred >= state.most) return;
    by.referred = true;
    ++state.referred;
  }
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    const float q = quality(by, state.seers[asked], by.resident);
    state.served[asked] = with(state.served[asked], part.seer, q);
  }
}

// A view that the cell can no longer refer to makes room for the resident one that shows most of it.
void TileChoice::give_up(const Part& part) {
  CellState& state = cells_[part.cell];
  Seer& by = state.seers[part.seer];
  by.resident -= part.pixels;
  if (!by.referred) return;
  if (by.resident == 0) {
    by.referred = false;
    --state.referred;
    Seer* next = nullptr;
    for (Seer& seer : state.seers) {
      if (!seer.referred && seer.resident > (next ? next->resident : 0)) next = &seer;
    }
    if (next) {
      next->referred = true;
      ++state.referred;
    }
  }
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    Served& served = state.served[asked];
    served = {};
    for (std::uint32_t seer = 0; seer < state.seers.size(); ++seer) {
      const Seer& other = state.seers[seer];
      if (other.referred) served = with(served, seer, quality(other, state.seers[asked], other.resident));
    }
  }
}

double TileChoice::worth() const {
  double sum = 0;
  for (const CellState& state : cells_) {
    for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
      sum += static_cast<double>(state.seers[asked].pixels) * static_cast<double>(worth_of(state.served[asked]));
    }
  }
  return sum;
}

// By what they gain per tile, until one does not fit.
void TileChoice::take_whole_views(std::size_t count) {
  LazyQueue queue([this](std::uint32_t number) {
    const WholeView& view = whole_views_[number];
    return gain(view.parts) / static_cast<double>(view.tiles.end - view.tiles.first);
  });
  for (std::uint32_t number = 0; number < whole_views_.size(); ++number) {
    if (taken_[whole_views_[number].tiles.first] == 0) queue.add(number);
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

// Gives up the tiles of the least loss, which only grows as others go.
void TileChoice::trim(std::size_t count) {
  LazyQueue queue([this](std::uint32_t tile) { return -loss(candidates_[tile].parts); });
  for (std::uint32_t tile = 0; tile < candidates_.size(); ++tile) {
    if (taken_[tile] != 0) queue.add(tile);
  }
  for (; taken_count_ > count; --taken_count_) {
    const std::uint32_t tile = queue.take()->number;
    const Range& parts = candidates_[tile].parts;
    for (std::uint32_t part = parts.first; part < parts.end; ++part) give_up(parts_[part]);
    taken_[tile] = 0;
  }
}

void TileChoice::fill(std::size_t count) {
  LazyQueue queue([this](std::uint32_t tile) { return gain(candidates_[tile].parts); });
  for (std::uint32_t tile = 0; tile < candidates_.size() && taken_count_ < count; ++tile) {
    if (taken_[tile] == 0) queue.add(tile);
  }
  for (; taken_count_ < count; ++taken_count_) {
    const auto top = queue.take();
    if (!top || !(top->value > 0)) return;
    const Range& parts = candidates_[top->number].parts;
    for (std::uint32_t part = parts.first; part < parts.end; ++part) take(parts_[part]);
    taken_[top->number] = 1;
  }
}

std::vector<ViewTile> TileChoice::choose(std::size_t count) {
  take_whole_views(count);
  TileChoice fitting = *this;
  take_whole_views(static_cast<std::size_t>(kUntrimmed * static_cast<double>(count)));
  trim(count);
  fill(count);
  fitting.fill(count);
  if (fitting.worth() > worth()) *this = std::move(fitting);
  std::vector<ViewTile> chosen;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    if (taken_[i] != 0) chosen.push_back(candidates_[i].tile);
  }
  return chosen;
}

ReferenceTable TileChoice::references() const {
  ReferenceTable table;
  for (const CellState& state : cells_) {
    for (const Seer& seer : state.seers) {
      if (seer.referred) table.views.push_back(seer.view);
    }
    table.offsets.push_back(static_cast<std::uint32_t>(table.views.size()));
  }
  return table;
}

}  // namespace

std::vector<ViewTile> choose_tiles(std::span<const std::shared_ptr<const StoredView>> views, const Cells& cells,
                                   std::span<const std::vector<ShownCell>> shown, std::size_t count,
                                   ReferenceTable& references) {
  TileChoice choice(views, cells, shown, references);
  std::vector<ViewTile> tiles = choice.choose(count);
  references = choice.references();
  return tiles;
}

}  // namespace lumatlas
