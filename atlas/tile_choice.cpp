// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/tile_choice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <queue>
#include <tuple>

namespace lumatlas {

namespace {

constexpr float kLambda = 0.8f;
constexpr double kWidthDegrees = 30;
constexpr std::size_t kBlended = 3;
constexpr std::array<float, kBlended> kRankValue{4.0f / 7, 2.0f / 7, 1.0f / 7};

// A view that sees a cell.
struct Seer {
  std::uint32_t view;
  std::uint32_t pixels = 0;  // of the cell in it
  float share = 0;           // of these, in resident tiles
  glm::vec3 direction{0};    // unit, from the cell
  float resolution = 0;      // pixels per length
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
  std::size_t resident = 0;    // seers with a share
  std::size_t most = 0;        // of those
};

// A part of a cell, as a tile shows it.
struct Part {
  std::uint32_t cell;
  std::uint32_t seer;
  float share;
};

struct Candidate {
  ViewTile tile;
  std::uint32_t first, end;  // parts
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
  [[nodiscard]] double gain(const Candidate& candidate) const;
  [[nodiscard]] double gain(const Part& part) const;
  void take(const Part& part);

  std::vector<CellState> cells_;
  std::vector<Part> parts_;
  std::vector<Candidate> candidates_;
};

float quality(const Seer& by, const Seer& asked, float share) {
  static const auto kScale = static_cast<float>(1 / (1 - std::cos(glm::radians(kWidthDegrees))));
  const float k = std::clamp(1 - (1 - glm::dot(by.direction, asked.direction)) * kScale, 0.0f, 1.0f);
  const float resolution = std::min(1.0f, by.resolution / asked.resolution);
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

float worth(const Served& served) {
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
  for (std::uint32_t view = 0; view < shown.size(); ++view) add_candidates(view, shown[view]);
}

void TileChoice::add_seers(std::uint32_t view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    std::vector<Seer>& seers = cells_[part.cell].seers;
    if (seers.empty() || seers.back().view != view) seers.push_back({view});
    seers.back().pixels += part.pixels;
  }
}

void TileChoice::add_candidates(std::uint32_t view, std::span<const ShownCell> shown) {
  for (const ShownCell& part : shown) {
    const bool known =
        !candidates_.empty() && candidates_.back().tile.view == view && candidates_.back().tile.tile == part.tile;
    if (!known) {
      const auto first = static_cast<std::uint32_t>(parts_.size());
      candidates_.push_back({{view, part.tile}, first, first});
    }
    if (part.pixels == 0) continue;
    const std::vector<Seer>& seers = cells_[part.cell].seers;
    const auto seer = std::lower_bound(seers.begin(), seers.end(), view,
                                       [](const Seer& s, std::uint32_t number) { return s.view < number; });
    parts_.push_back({part.cell, static_cast<std::uint32_t>(seer - seers.begin()),
                      static_cast<float>(part.pixels) / static_cast<float>(seer->pixels)});
    candidates_.back().end = static_cast<std::uint32_t>(parts_.size());
  }
}

double TileChoice::gain(const Part& part) const {
  const CellState& state = cells_[part.cell];
  const Seer& by = state.seers[part.seer];
  if (by.share == 0 && state.resident >= state.most) return 0;  // the cell may not refer to it
  double sum = 0;
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    const float q = quality(by, state.seers[asked], by.share + part.share);
    const Served& served = state.served[asked];
    if (q <= served.best[kBlended - 1].quality) continue;
    sum += static_cast<double>(state.seers[asked].pixels) *
           static_cast<double>(worth(with(served, part.seer, q)) - worth(served));
  }
  return sum;
}

double TileChoice::gain(const Candidate& candidate) const {
  double sum = 0;
  for (std::uint32_t part = candidate.first; part < candidate.end; ++part) sum += gain(parts_[part]);
  return sum;
}

void TileChoice::take(const Part& part) {
  CellState& state = cells_[part.cell];
  Seer& by = state.seers[part.seer];
  if (by.share == 0) {
    if (state.resident >= state.most) return;
    ++state.resident;
  }
  by.share += part.share;
  for (std::size_t asked = 0; asked < state.seers.size(); ++asked) {
    const float q = quality(by, state.seers[asked], by.share);
    state.served[asked] = with(state.served[asked], part.seer, q);
  }
}

// Lazily: what a tile gains only falls as others come.
std::vector<ViewTile> TileChoice::choose(std::size_t count) {
  using Entry = std::tuple<double, std::int64_t>;  // gain, negative index: of equals the first
  std::priority_queue<Entry> queue;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    queue.emplace(gain(candidates_[i]), -static_cast<std::int64_t>(i));
  }
  std::vector<ViewTile> chosen;
  while (chosen.size() < count && !queue.empty()) {
    const std::int64_t index = std::get<1>(queue.top());
    const Candidate& candidate = candidates_[static_cast<std::size_t>(-index)];
    queue.pop();
    const double now = gain(candidate);
    if (!queue.empty() && Entry(now, index) < queue.top()) {
      queue.emplace(now, index);
      continue;
    }
    if (!(now > 0)) break;
    for (std::uint32_t part = candidate.first; part < candidate.end; ++part) take(parts_[part]);
    chosen.push_back(candidate.tile);
  }
  std::sort(chosen.begin(), chosen.end(),
            [](const ViewTile& a, const ViewTile& b) { return std::tie(a.view, a.tile) < std::tie(b.view, b.tile); });
  return chosen;
}

ReferenceTable TileChoice::references() const {
  ReferenceTable table;
  for (const CellState& state : cells_) {
    for (const Seer& seer : state.seers) {
      if (seer.share > 0) table.views.push_back(seer.view);
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
