// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Erat et al. 2019, section 4.9. Minoux, "Accelerated greedy algorithms for maximizing submodular set
// functions", 1978. Nemhauser, Wolsey, Fisher, "An analysis of approximations for maximizing submodular set
// functions", 1978.
#include "planner/offline_planner.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>
#include <stdexcept>
#include <string>

#include "mesh/base/number_text.h"
#include "planner/coverage/coverage_ledger.h"

namespace lumatlas {

namespace {

// An exchange must raise scov by more than this share of it: less is the rounding of its running sum.
constexpr double kLeastRise = 1e-9;

struct Candidate {
  double gain;  // the gain when `chosen` views had been chosen
  std::uint32_t view;
  std::uint32_t chosen;

  [[nodiscard]] bool operator<(const Candidate& other) const {
    return gain < other.gain || (gain == other.gain && view > other.view);
  }
};

class OfflinePlanner {
 public:
  OfflinePlanner(const Surface& surface, std::span<const std::vector<CellPart>> views, std::uint32_t count,
                 const OfflineOptions& options)
      : views_(views),
        cancel_check_(options.cancel_check),
        count_(std::min<std::size_t>(count, views.size())),
        ledger_(surface, static_cast<std::uint32_t>(count_), options.coverage, options.min_reference_gain) {
    for (const std::vector<CellPart>& parts : views) {
      check_cancelled(cancel_check_);
      ledger_.add_demand(parts);
    }
  }

  OfflineChoice plan(std::uint32_t max_passes) {
    select_greedily();
    choice_.greedy_coverage = choice_.summed_coverage = ledger_.summed_coverage();
    choice_.views = view_in_slot_;
    for (std::uint32_t pass = 0; pass < max_passes && !view_in_slot_.empty(); ++pass) {
      choice_.exchanges.push_back(exchange());
      // A pass whose gains are only foreseen (Metric::paper) may do harm, and is then not counted.
      if (!(ledger_.summed_coverage() > choice_.summed_coverage)) break;
      choice_.summed_coverage = ledger_.summed_coverage();
      choice_.views = view_in_slot_;
    }
    std::sort(choice_.views.begin(), choice_.views.end());
    return choice_;
  }

 private:
  void select_greedily() {
    std::priority_queue<Candidate> queue;
    for (std::uint32_t view = 0; view < views_.size(); ++view) queue.push(evaluated(view));
    while (view_in_slot_.size() < count_) {
      const Candidate best = queue.top();
      queue.pop();
      if (best.chosen < view_in_slot_.size()) {
        queue.push(evaluated(best.view));
        continue;
      }
      if (!(best.gain > 0)) return;
      ledger_.insert(ViewSlot(best.chosen), views_[best.view]);
      view_in_slot_.push_back(best.view);
    }
  }

  Candidate evaluated(std::uint32_t view) {
    check_cancelled(cancel_check_);
    ++choice_.evaluations;
    return {ledger_.gain(views_[view]), view, static_cast<std::uint32_t>(view_in_slot_.size())};
  }

  // One pass: each view that is not chosen takes the place of the one against which it gains most.
  std::size_t exchange() {
    std::vector<ViewSlot> slots(view_in_slot_.size());
    std::iota(slots.begin(), slots.end(), ViewSlot{0});
    std::vector<bool> chosen(views_.size(), false);
    for (const std::uint32_t view : view_in_slot_) chosen[view] = true;
    std::size_t exchanges = 0;
    for (std::uint32_t view = 0; view < views_.size(); ++view) {
      if (chosen[view]) continue;
      check_cancelled(cancel_check_);
      const std::vector<double> gains = ledger_.exchange_gains(views_[view], slots);
      const auto best = std::max_element(gains.begin(), gains.end());
      if (!(*best > kLeastRise * ledger_.summed_coverage())) continue;
      const ViewSlot slot = slots[static_cast<std::size_t>(best - gains.begin())];
      chosen[view_in_slot_[slot]] = false;
      chosen[view] = true;
      ledger_.erase(slot);
      ledger_.insert(slot, views_[view]);
      view_in_slot_[slot] = view;
      ++exchanges;
    }
    return exchanges;
  }

  std::span<const std::vector<CellPart>> views_;
  const CancelCheck& cancel_check_;
  std::size_t count_;
  CoverageLedger ledger_;
  std::vector<std::uint32_t> view_in_slot_;
  OfflineChoice choice_;
};

}  // namespace

OfflineChoice plan_offline(const Surface& surface, std::span<const std::vector<CellPart>> views, std::uint32_t count,
                           const OfflineOptions& options) {
  check(options.coverage);
  if (!(std::isfinite(options.min_reference_gain) && options.min_reference_gain >= 0)) {
    throw std::invalid_argument("offline planner: min_reference_gain is " + number_text(options.min_reference_gain) +
                                ", must be finite and not negative");
  }
  if (count < 1) throw std::invalid_argument("offline planner: count is 0, must be at least 1");
  return OfflinePlanner(surface, views, count, options).plan(options.max_passes);
}

}  // namespace lumatlas
