// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Erat et al. 2019, sections 3.2 and 3.4.
#include "planner/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "atlas/tiles/texel_format.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

constexpr std::size_t kDistanceSamples = 16;
constexpr std::uint32_t kDistanceImagePx = 160;

// Adds the time that it lives to a field, in milliseconds.
class Stopwatch {
 public:
  explicit Stopwatch(double& total_ms) : total_ms_(total_ms), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() {
    total_ms_ += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_ms_;
  std::chrono::steady_clock::time_point start_;
};

// Counts the cells that a view sees as asked for (CellDemand). Unless confirm() is called, that is taken back at the
// end of the scope: a view that turns out to be an outlier stood elsewhere, and one whose photograph cannot be had is
// to leave no trace.
class PendingDemand {
 public:
  PendingDemand(CoverageLedger& ledger, std::optional<OfferedCoverage>& offered, std::span<const CellPart> seen)
      : ledger_(ledger), offered_(offered), seen_(seen) {
    ledger.ask(seen);
    if (offered) offered->ask(seen);
  }
  ~PendingDemand() {
    if (confirmed_) return;
    ledger_.unask(seen_);
    if (offered_) offered_->unask(seen_);
  }
  PendingDemand(const PendingDemand&) = delete;
  PendingDemand& operator=(const PendingDemand&) = delete;
  void confirm() { confirmed_ = true; }

 private:
  CoverageLedger& ledger_;
  std::optional<OfferedCoverage>& offered_;
  std::span<const CellPart> seen_;
  bool confirmed_ = false;
};

constexpr Requirement planner_requires{"planner"};

const PlannerOptions& checked(const PlannerOptions& options) {
  check(options);
  return options;
}

}  // namespace

void check(const PlannerOptions& options) {
  check(options.coverage);
  check(options.validity);
  check(options.refinement);
  planner_requires(std::isfinite(options.min_view_gain) && options.min_view_gain >= 0, "min_view_gain",
                   options.min_view_gain, "finite and not negative");
  planner_requires(std::isfinite(options.min_reference_gain) && options.min_reference_gain >= 0, "min_reference_gain",
                   options.min_reference_gain, "finite and not negative");
  planner_requires(std::isfinite(options.min_exchange_gain) && options.min_exchange_gain >= 0, "min_exchange_gain",
                   options.min_exchange_gain, "finite and not negative");
  if (options.max_loss_db) {
    planner_requires(std::isfinite(*options.max_loss_db) && *options.max_loss_db >= 0, "max_loss_db",
                     *options.max_loss_db, "finite and not negative");
    planner_requires(options.coverage.metric == CoverageOptions::Metric::directions, "max_loss_db",
                     *options.max_loss_db, "none with Metric::paper, for which there is no law");
  }
  planner_requires(options.visibility_px >= 1, "visibility_px", options.visibility_px, "at least 1");
}

namespace {

void require_source(const std::string& name, const PhotographSource& photograph) {
  if (!photograph) throw std::invalid_argument("planner: view " + name + ": there is no function for its photograph");
}

// Three values of colour a pixel, and one, or none at all, of the lens's image.
void require_pixels(const std::string& name, const Photograph& photograph) {
  const std::size_t pixels = std::size_t{photograph.width} * photograph.height;
  const auto refuse = [&](const char* field, std::size_t size, std::size_t expected) {
    throw std::invalid_argument("planner: view " + name + ": the size of photograph." + field + " is " +
                                std::to_string(size) + ", must be " + std::to_string(expected));
  };
  if (photograph.rgb.size() != 3 * pixels) refuse("rgb", photograph.rgb.size(), 3 * pixels);
  if (!photograph.valid.empty() && photograph.valid.size() != pixels) refuse("valid", photograph.valid.size(), pixels);
}

}  // namespace

std::uint64_t stored_bytes(const Camera& camera) {
  return kStoredPixelBytes * camera.width * camera.height;
}

double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility) {
  std::vector<float> depths;
  VisibilityBuffer buffer;
  const std::size_t samples = std::min(kDistanceSamples, cameras.size());
  const auto look = [&](const Camera& camera) {
    check(camera);
    visibility.trace(camera.shrunk_to(kDistanceImagePx), buffer);
    std::copy_if(buffer.depth.begin(), buffer.depth.end(), std::back_inserter(depths),
                 [](float depth) { return std::isfinite(depth); });
  };
  for (std::size_t i = 0; i < samples; ++i) look(cameras[i * cameras.size() / samples]);
  for (std::size_t i = 0; i < cameras.size() && depths.empty(); ++i) look(cameras[i]);
  if (depths.empty()) {
    throw InputError("none of the cameras sees the mesh (" + std::to_string(cameras.size()) +
                     " were asked): give the mesh in the cameras' coordinates");
  }
  const auto median = static_cast<double>(upper_median(depths));
  if (!(median > 0)) {
    throw InputError(
        "the cameras stand on the mesh: half of what they see is at no distance, give the mesh in their coordinates "
        "and "
        "units");
  }
  return median;
}

Planner::Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options)
    : atlas_(atlas),
      visibility_(&visibility),
      options_(options),
      refiner_(atlas, visibility, options.refinement),
      ledger_(*atlas.surface(), atlas.capacity(), checked(options).coverage, options.min_reference_gain),
      promised_(atlas.capacity()),
      slot_bytes_(atlas.capacity(), 0) {
  if (atlas.size() != 0) throw std::invalid_argument("planner: the atlas holds views already, must be empty");
  if (options.max_loss_db) offered_.emplace(*atlas.surface(), options.coverage);
}

// The camera whose image cells are counted in.
Camera Planner::planning_camera(const Camera& camera) const {
  return camera.shrunk_to(options_.visibility_px);
}

std::vector<CellPart> Planner::parts(const Camera& small, std::span<const CellPixels> seen) const {
  const std::shared_ptr<const Surface> surface = atlas_.surface();
  const Cells& cells = surface->cells;
  std::vector<CellPart> parts;
  parts.reserve(seen.size());
  for (const CellPixels& count : seen) {
    parts.push_back(
        {count.cell, contribution(cells.cells[count.cell], cells.size, small, count.pixels, options_.coverage)});
  }
  return parts;
}

std::vector<float> Planner::cell_coverage() const {
  std::vector<float> coverage(atlas_.surface()->cells.cells.size());
  for (std::uint32_t cell = 0; cell < coverage.size(); ++cell) {
    const double weight = ledger_.weight(cell);
    coverage[cell] = weight > 0 ? static_cast<float>(ledger_.coverage(cell) / weight) : 0.0f;
  }
  return coverage;
}

std::vector<CellPart> Planner::parts_of(const Camera& camera) const {
  check(camera);
  const Camera small = planning_camera(camera);
  return parts(small, count_cell_pixels(visibility_->trace(small), atlas_.surface()->cells));
}

std::vector<CellPart> Planner::look(const Camera& camera, Verdict& verdict) {
  check(camera);
  const Stopwatch stopwatch(verdict.visibility_ms);
  const Camera small = planning_camera(camera);
  visibility_->trace(small, buffer_);
  const std::vector<CellPixels> seen = count_cell_pixels(buffer_, atlas_.surface()->cells);
  verdict.cells_seen = static_cast<std::uint32_t>(seen.size());
  return parts(small, seen);
}

// Marks the cells of a view in the atlas as seen. Called once its offer can no longer fail.
void Planner::note_seen(std::span<const CellPart> seen) {
  std::vector<CellPixels> cells;
  cells.reserve(seen.size());
  for (const CellPart& part : seen) cells.push_back({part.cell, 1});
  atlas_.mark_seen(cells);
}

std::vector<std::uint32_t> Planner::stored_slots() const {
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < atlas_.capacity(); ++slot) {
    if (ledger_.stored(slot)) slots.push_back(slot);
  }
  return slots;
}

std::vector<std::uint32_t> Planner::lowest_ranked(const CoverageLedger& ledger, std::vector<std::uint32_t> slots,
                                                  std::size_t count) {
  if (count >= slots.size()) return slots;
  std::partial_sort(
      slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count), slots.end(),
      [&](std::uint32_t a, std::uint32_t b) { return std::pair(ledger.loss(a), a) < std::pair(ledger.loss(b), b); });
  slots.resize(count);
  return slots;
}

bool Planner::fits(std::uint64_t bytes, std::uint64_t freed_bytes, std::uint32_t freed_slots) const {
  if (held_views_ - freed_slots >= atlas_.capacity()) return false;
  return options_.max_bytes == 0 || stored_bytes_ - freed_bytes + bytes <= options_.max_bytes;
}

Planner::Exchange Planner::best_exchange(std::span<const CellPart> parts, std::uint64_t bytes) const {
  if (fits(bytes, 0, 0)) return {{}, ledger_.gain(parts)};
  std::vector<std::uint32_t> candidates = stored_slots();
  std::erase_if(candidates, [&](std::uint32_t slot) { return !fits(bytes, bytes_of(slot), 1); });
  if (candidates.empty()) return joint_exchange(parts, bytes);
  const bool each_makes_room = candidates.size() == held_views_;
  if (options_.victims > 0) candidates = lowest_ranked(ledger_, std::move(candidates), options_.victims);
  const std::vector<double> gains = ledger_.exchange_gains(parts, candidates);
  const auto best = std::max_element(gains.begin(), gains.end());
  Exchange single{{candidates[static_cast<std::size_t>(best - gains.begin())]}, *best};
  if (each_makes_room) return single;
  Exchange joint = joint_exchange(parts, bytes);  // views too small to make room alone may be worth less together
  return joint.gain > single.gain ? joint : single;
}

// Those views leave together that are worth least for their size, as many as it takes.
Planner::Exchange Planner::joint_exchange(std::span<const CellPart> parts, std::uint64_t bytes) const {
  std::vector<std::uint32_t> slots = stored_slots();
  const auto density = [&](std::uint32_t slot) {
    return ledger_.loss(slot) / static_cast<double>(std::max<std::uint64_t>(bytes_of(slot), 1));
  };
  std::sort(slots.begin(), slots.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(density(a), a) < std::pair(density(b), b); });
  Exchange exchange;
  std::uint64_t freed = 0;
  while (!fits(bytes, freed, static_cast<std::uint32_t>(exchange.victims.size()))) {
    exchange.victims.push_back(slots[exchange.victims.size()]);
    freed += bytes_of(exchange.victims.back());
  }
  // A large one that came late may make room enough without some that came before it.
  for (std::size_t i = exchange.victims.size(); i-- > 0;) {
    const std::uint64_t less = freed - bytes_of(exchange.victims[i]);
    if (!fits(bytes, less, static_cast<std::uint32_t>(exchange.victims.size() - 1))) continue;
    freed = less;
    exchange.victims.erase(exchange.victims.begin() + static_cast<std::ptrdiff_t>(i));
  }
  exchange.gain = ledger_.joint_exchange_gain(parts, exchange.victims);
  return exchange;
}

std::string Planner::name_of(std::uint32_t slot) const {
  return promised_[slot] ? promised_[slot]->name : atlas_.view(slot)->name;
}

bool Planner::is_worth_it(const Exchange& exchange, std::span<const CellPart> seen) const {
  double least = options_.min_view_gain * ledger_.weight(seen);
  if (!exchange.victims.empty()) {
    least = std::max(least, options_.min_exchange_gain * ledger_.summed_coverage() / held_views_);
  }
  return exchange.gain > least;
}

void Planner::require_room_for(const std::string& name, const Camera& camera) const {
  const std::uint64_t bytes = lumatlas::stored_bytes(camera);
  if (options_.max_bytes == 0 || bytes <= options_.max_bytes) return;
  throw std::invalid_argument("planner: view " + name + " takes " + std::to_string(bytes) +
                              " bytes, more than all views together may (" + std::to_string(options_.max_bytes) + ")");
}

// None if the view is not worth its place.
std::optional<Planner::Exchange> Planner::exchange_for(const Camera& camera, std::span<const CellPart> seen,
                                                       Verdict& verdict) {
  const Stopwatch stopwatch(verdict.plan_ms);
  Exchange exchange = best_exchange(seen, lumatlas::stored_bytes(camera));
  verdict.gain = exchange.gain;
  const bool needed = is_needed(seen);
  short_of_room_ = short_of_room_ || (needed && !exchange.victims.empty());
  if (!needed || !is_worth_it(exchange, seen)) return std::nullopt;
  return exchange;
}

void Planner::require_offer(const std::string& name, const Camera& camera, const PhotographSource& photograph) const {
  require_source(name, photograph);
  check(camera);
  require_room_for(name, camera);
}

void Planner::decide(const std::string& name, const Camera& camera, const PhotographSource& photograph,
                     const std::vector<CellPart>& seen, Verdict& verdict) {
  const std::optional<Exchange> exchange = exchange_for(camera, seen, verdict);
  if (exchange) take(name, camera, seen, *exchange, photograph(), verdict);
}

Verdict Planner::offer(const std::string& name, const Camera& camera, const PhotographSource& photograph) {
  require_offer(name, camera, photograph);
  Verdict verdict;
  const std::vector<CellPart> seen = look(camera, verdict);
  PendingDemand demand(ledger_, offered_, seen);
  decide(name, camera, photograph, seen, verdict);
  note_seen(seen);
  if (verdict.decision == Decision::outlier) return verdict;
  demand.confirm();
  count_offered(seen);
  return verdict;
}

Verdict Planner::reserve(const std::string& name, const Camera& camera) {
  if (offered_) throw std::logic_error("planner: nothing can be reserved with max_loss_db");
  check(camera);
  require_room_for(name, camera);
  Verdict verdict;
  const std::vector<CellPart> seen = look(camera, verdict);
  PendingDemand demand(ledger_, offered_, seen);
  const std::optional<Exchange> exchange = exchange_for(camera, seen, verdict);
  demand.confirm();
  if (!exchange) {
    note_seen(seen);
    return verdict;
  }
  claim_slot(camera, seen, *exchange, verdict);
  promised_[*verdict.slot] = Promise{name, camera};
  return verdict;
}

Verdict Planner::offer_again(const std::string& name, const Camera& camera, const PhotographSource& photograph) {
  if (offered_) throw std::logic_error("planner: nothing can be offered again with max_loss_db");
  require_offer(name, camera, photograph);
  Verdict verdict;
  const std::vector<CellPart> seen = look(camera, verdict);
  decide(name, camera, photograph, seen, verdict);
  note_seen(seen);
  if (verdict.decision == Decision::outlier) ledger_.unask(seen);
  return verdict;
}

Verdict Planner::offer(const std::string& name, const Camera& camera, Photograph photograph) {
  return offer(name, camera, [&] { return std::move(photograph); });
}

Verdict Planner::keep(const std::string& name, const Camera& camera, const PhotographSource& photograph) {
  require_source(name, photograph);
  check(camera);
  if (!fits(lumatlas::stored_bytes(camera), 0, 0)) {
    throw std::invalid_argument("planner: there is no room to keep view " + name);
  }
  Verdict verdict;
  std::vector<CellPart> seen = look(camera, verdict);
  PendingDemand demand(ledger_, offered_, seen);
  const Exchange exchange{{}, ledger_.gain(seen)};
  verdict.gain = exchange.gain;
  take(name, camera, seen, exchange, photograph(), verdict);
  note_seen(seen);
  if (verdict.decision == Decision::outlier) return verdict;
  demand.confirm();
  count_offered(seen);
  return verdict;
}

void Planner::pass_by(const Camera& camera) {
  Verdict unused;
  const std::vector<CellPart> seen = look(camera, unused);
  PendingDemand(ledger_, offered_, seen).confirm();
  note_seen(seen);
  count_offered(seen);
}

void Planner::claim_slot(const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange,
                         Verdict& verdict) {
  verdict.decision = exchange.victims.empty() ? Decision::kept : Decision::replaced;
  for (const std::uint32_t victim : exchange.victims) {
    verdict.replaced.push_back(name_of(victim));
    evict(victim);
  }
  std::uint32_t slot = 0;
  while (ledger_.stored(slot)) ++slot;
  verdict.slot = slot;
  ledger_.insert(slot, seen);
  ++held_views_;
  slot_bytes_[slot] = lumatlas::stored_bytes(camera);
  stored_bytes_ += slot_bytes_[slot];
}

// Returns whether the photograph belongs into the store.
bool Planner::refine(const std::string& name, const Camera& camera, const Photograph& photograph, Verdict& verdict) {
  require_photograph_of(name, camera, photograph);
  require_pixels(name, photograph);
  if (!options_.refinement.any()) return true;
  const Stopwatch stopwatch(verdict.refine_ms);
  verdict.refinement = refiner_.refine(camera, photograph);
  if (!verdict.refinement->outlier) return true;
  verdict.refinement->prepared.reset();
  verdict.decision = Decision::outlier;
  return false;
}

Planner::ReadyView Planner::ready(const std::string& name, const Camera& camera, Photograph photograph,
                                  Verdict& verdict) const {
  const Stopwatch stopwatch(verdict.store_ms);
  const Camera refined = verdict.refinement ? verdict.refinement->alignment.camera : camera;
  VisibilityBuffer visible = visibility_->trace_sparsely(refined);
  std::vector<std::uint32_t> face = visible.face;
  return {make_tiled_view(name, refined, std::move(photograph), std::move(visible), atlas_.surface()->cells,
                          atlas_.layout(), options_.validity),
          std::move(face)};
}

// In the verdict's slot, which is the view's in the ledger already.
void Planner::store(ReadyView ready, const Camera& camera, Verdict& verdict) {
  const Stopwatch stopwatch(verdict.store_ms);
  const std::uint32_t slot = *verdict.slot;
  atlas_.insert_at(slot, std::move(ready.tiled.view), std::move(ready.tiled.shown));
  promised_[slot].reset();
  publish(ledger_.parts(slot));
  if (!verdict.refinement) return;
  refiner_.stored(slot, camera, *verdict.refinement, options_.validity, ready.face);
  verdict.refinement->prepared.reset();  // verdicts are kept for longer than photographs
}

// Stores the view unless it is an outlier. `seen` was counted at the given pose, and stays.
void Planner::take(const std::string& name, const Camera& camera, const std::vector<CellPart>& seen,
                   const Exchange& exchange, Photograph photograph, Verdict& verdict) {
  if (!refine(name, camera, photograph, verdict)) return;
  ReadyView view = ready(name, camera, std::move(photograph), verdict);
  claim_slot(camera, seen, exchange, verdict);
  store(std::move(view), camera, verdict);
}

void Planner::fill(const std::string& name, const PhotographSource& photograph, Verdict& verdict) {
  if (!verdict.slot || !is_promised(name, *verdict.slot)) {
    throw std::logic_error("planner: view " + name + " is promised no slot");
  }
  require_source(name, photograph);
  const std::uint32_t slot = *verdict.slot;
  const Camera camera = promised_[slot]->camera;
  Photograph read = photograph();
  if (refine(name, camera, read, verdict)) {
    store(ready(name, camera, std::move(read), verdict), camera, verdict);
    note_seen(ledger_.parts(slot));
    return;
  }
  note_seen(ledger_.parts(slot));
  ledger_.unask(ledger_.parts(slot));
  evict(slot);
  verdict.slot.reset();
  verdict.replaced.clear();
}

bool Planner::is_promised(const std::string& name, std::uint32_t slot) const {
  return slot < promised_.size() && promised_[slot] && promised_[slot]->name == name;
}

void Planner::evict(std::uint32_t slot) {
  const std::vector<CellPart> seen(ledger_.parts(slot).begin(), ledger_.parts(slot).end());
  const bool promised = promised_[slot].has_value();
  stored_bytes_ -= bytes_of(slot);
  --held_views_;
  ledger_.erase(slot);
  promised_[slot].reset();
  publish(seen);
  if (promised) return;
  refiner_.erased(slot);
  atlas_.erase(slot);
}

// Views that are promised a slot have nothing yet to refer to.
void Planner::publish(std::span<const CellPart> cells) {
  for (const CellPart& entry : cells) {
    std::vector<std::uint32_t> references = ledger_.references(entry.cell);
    std::erase_if(references, [&](std::uint32_t slot) { return promised_[slot].has_value(); });
    atlas_.set_references(entry.cell, std::move(references));
  }
}

}  // namespace lumatlas
