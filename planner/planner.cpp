// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Erat et al. 2019, sections 3.2 and 3.4.
#include "planner/planner.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "planner/coverage/predicted_loss.h"
#include "planner/exchange.h"

namespace lumatlas {

namespace {

// The share of PlannerOptions::max_loss_db that may be lost while the stream goes on. It is below 1, because a rejected
// view does not come back and a stored one can still be evicted: Pruning::prune() chooses better among more views.
constexpr double kShareWhileGrowing = 0.5;

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

// Adds the demand of a view (CellDemand). Unless confirm() is called, the end of the scope removes it: an outlier was
// not taken where its pose says, and a view whose photograph cannot be read leaves no trace.
class PendingDemand {
 public:
  PendingDemand(PlannedStore& store, std::span<const CellPart> seen) : store_(store), seen_(seen) {
    store.add_demand(seen);
  }
  ~PendingDemand() {
    if (!confirmed_) store_.remove_demand(seen_);
  }
  PendingDemand(const PendingDemand&) = delete;
  PendingDemand& operator=(const PendingDemand&) = delete;
  void confirm() { confirmed_ = true; }

 private:
  PlannedStore& store_;
  std::span<const CellPart> seen_;
  bool confirmed_ = false;
};

const PlannerOptions& checked(const PlannerOptions& options) {
  check(options);
  return options;
}

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

Planner::Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options)
    : atlas_(atlas),
      visibility_(&visibility),
      options_(checked(options)),
      refiner_(atlas, visibility, options.refinement, options.validity),
      store_(atlas, refiner_, options_) {}

// The camera whose image cells are counted in.
Camera Planner::planning_camera(const Camera& camera) const {
  return camera.shrunk_to(options_.visibility_px);
}

std::vector<CellPart> Planner::parts(const Camera& small, std::span<const CellPixels> seen) const {
  return cell_parts(atlas_.surface()->cells, small, seen, options_.coverage);
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

bool Planner::is_worth_it(const Exchange& exchange, std::span<const CellPart> seen) const {
  const CoverageLedger& ledger = store_.ledger();
  double least = options_.min_view_gain * ledger.weight(seen);
  if (!exchange.victims.empty()) {
    least = std::max(least, options_.min_exchange_gain * ledger.summed_coverage() / store_.held_views());
  }
  return exchange.gain > least;
}

// Returns whether the store needs the view: see PlannerOptions::max_loss_db.
bool Planner::is_needed(std::span<const CellPart> seen) const {
  if (!store_.offered()) return true;
  return predicted_loss_db(store_.offered()->gap(store_.ledger(), seen)) > kShareWhileGrowing * *options_.max_loss_db;
}

void Planner::require_room_for(const std::string& name, const Camera& camera) const {
  const std::uint64_t bytes = stored_bytes(camera);
  if (options_.max_bytes == 0 || bytes <= options_.max_bytes) return;
  throw std::invalid_argument("planner: view " + name + " takes " + std::to_string(bytes) +
                              " bytes, more than all views together may (" + std::to_string(options_.max_bytes) + ")");
}

// Returns nothing if the view is not worth its place.
std::optional<Exchange> Planner::exchange_for(const Camera& camera, std::span<const CellPart> seen, Verdict& verdict) {
  const Stopwatch stopwatch(verdict.plan_ms);
  Exchange exchange = best_exchange(store_, seen, stored_bytes(camera));
  verdict.gain = exchange.gain;
  const bool needed = is_needed(seen);
  if (needed && !exchange.victims.empty()) store_.note_short_of_room();
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
  PendingDemand demand(store_, seen);
  decide(name, camera, photograph, seen, verdict);
  store_.note_seen(seen);
  if (verdict.decision == Decision::outlier) return verdict;
  demand.confirm();
  store_.count_offered(seen);
  return verdict;
}

Verdict Planner::reserve(const std::string& name, const Camera& camera, double sharpness) {
  if (store_.offered()) throw std::logic_error("planner: nothing can be reserved with max_loss_db");
  if (!(sharpness > 0 && sharpness <= 1)) throw std::invalid_argument("planner: sharpness must be in (0, 1]");
  check(camera);
  require_room_for(name, camera);
  Verdict verdict;
  std::vector<CellPart> seen = look(camera, verdict);
  for (CellPart& entry : seen) {
    entry.part.cell_share *= sharpness;
    entry.part.positional *= sharpness;
  }
  PendingDemand demand(store_, seen);
  const std::optional<Exchange> exchange = exchange_for(camera, seen, verdict);
  demand.confirm();
  if (!exchange) {
    store_.note_seen(seen);
    return verdict;
  }
  AtlasEdit edit;
  claim_slot(camera, seen, *exchange, verdict, edit);
  atlas_.commit(std::move(edit));
  store_.promise(*verdict.slot, name, camera);
  return verdict;
}

Verdict Planner::offer_again(const std::string& name, const Camera& camera, const PhotographSource& photograph) {
  if (store_.offered()) throw std::logic_error("planner: nothing can be offered again with max_loss_db");
  require_offer(name, camera, photograph);
  Verdict verdict;
  const std::vector<CellPart> seen = look(camera, verdict);
  decide(name, camera, photograph, seen, verdict);
  store_.note_seen(seen);
  if (verdict.decision == Decision::outlier) store_.remove_demand(seen);
  return verdict;
}

Verdict Planner::offer(const std::string& name, const Camera& camera, Photograph photograph) {
  return offer(name, camera, [&] { return std::move(photograph); });
}

Verdict Planner::force_store(const std::string& name, const Camera& camera, const PhotographSource& photograph) {
  require_source(name, photograph);
  check(camera);
  if (!store_.fits(stored_bytes(camera))) {
    throw std::invalid_argument("planner: there is no room to keep view " + name);
  }
  Verdict verdict;
  std::vector<CellPart> seen = look(camera, verdict);
  PendingDemand demand(store_, seen);
  const Exchange exchange{{}, store_.ledger().gain(seen)};
  verdict.gain = exchange.gain;
  take(name, camera, seen, exchange, photograph(), verdict);
  store_.note_seen(seen);
  if (verdict.decision == Decision::outlier) return verdict;
  demand.confirm();
  store_.count_offered(seen);
  return verdict;
}

void Planner::count_demand(const Camera& camera) {
  Verdict unused;
  const std::vector<CellPart> seen = look(camera, unused);
  PendingDemand(store_, seen).confirm();
  store_.note_seen(seen);
  store_.count_offered(seen);
}

void Planner::set_validity(const ValidityOptions& validity) {
  check(validity);
  options_.validity = validity;
  refiner_.set_validity(validity);
}

void Planner::claim_slot(const Camera& camera, const std::vector<CellPart>& seen, const Exchange& exchange,
                         Verdict& verdict, AtlasEdit& edit) {
  verdict.decision = exchange.victims.empty() ? Decision::kept : Decision::replaced;
  for (const ViewSlot victim : exchange.victims) {
    verdict.replaced.push_back(store_.name_of(victim));
    store_.evict(victim, edit);
  }
  verdict.slot = store_.claim(camera, seen);
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
  std::vector<FaceId> face = visible.face;
  return {make_tiled_view(name, refined, std::move(photograph), std::move(visible), atlas_.surface()->cells,
                          atlas_.layout(), options_.validity),
          std::move(face)};
}

// In the verdict's slot, which is the view's already. A snapshot has the view and all of `edit`, or none of it.
void Planner::put(ReadyView ready, const Camera& camera, Verdict& verdict, AtlasEdit edit) {
  const Stopwatch stopwatch(verdict.store_ms);
  store_.put(*verdict.slot, std::move(ready.tiled), edit);
  atlas_.commit(std::move(edit));
  if (!verdict.refinement) return;
  refiner_.add(*verdict.slot, camera, *verdict.refinement, ready.face);
  verdict.refinement->prepared.reset();  // verdicts are kept for longer than photographs
}

// Stores the view unless it is an outlier. `seen` was counted at the given pose, and stays.
void Planner::take(const std::string& name, const Camera& camera, const std::vector<CellPart>& seen,
                   const Exchange& exchange, Photograph photograph, Verdict& verdict) {
  if (!refine(name, camera, photograph, verdict)) return;
  ReadyView view = ready(name, camera, std::move(photograph), verdict);
  AtlasEdit edit;
  claim_slot(camera, seen, exchange, verdict, edit);
  put(std::move(view), camera, verdict, std::move(edit));
}

void Planner::store_reserved(const std::string& name, const PhotographSource& photograph, Verdict& verdict) {
  const Camera* promised = verdict.slot ? store_.promised_camera(name, *verdict.slot) : nullptr;
  if (promised == nullptr) throw std::logic_error("planner: view " + name + " is promised no slot");
  require_source(name, photograph);
  const ViewSlot slot = *verdict.slot;
  const Camera camera = *promised;
  Photograph read = photograph();
  const bool belongs = refine(name, camera, read, verdict);
  if (belongs) put(ready(name, camera, std::move(read), verdict), camera, verdict, AtlasEdit());
  store_.note_seen(store_.ledger().parts(slot));
  if (belongs) return;
  store_.remove_demand(store_.ledger().parts(slot));
  store_.evict(slot);
  verdict.slot.reset();
  verdict.replaced.clear();
}

}  // namespace lumatlas
