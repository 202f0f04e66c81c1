// SPDX-License-Identifier: GPL-3.0-or-later
// Sources: Erat et al. 2019, sections 3.2 and 3.4.
#include "planner/planner.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mesh/errors.h"
#include "planner/surface_samples.h"

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

void require(bool holds, const char* field, double value, const char* rule) {
  if (!holds) {
    throw std::invalid_argument("planner: " + std::string(field) + " is " + std::to_string(value) + ", must be " +
                                rule);
  }
}

}  // namespace

void check(const PlannerOptions& options) {
  check(options.coverage);
  check(options.validity);
  check(options.refinement);
  require(std::isfinite(options.min_view_gain) && options.min_view_gain >= 0, "min_view_gain", options.min_view_gain,
          "finite and not negative");
  require(std::isfinite(options.min_reference_gain) && options.min_reference_gain >= 0, "min_reference_gain",
          options.min_reference_gain, "finite and not negative");
  require(options.victims >= 1, "victims", options.victims, "at least 1");
  require(options.visibility_px >= 1, "visibility_px", options.visibility_px, "at least 1");
}

double median_surface_distance(std::span<const Camera> cameras, const Visibility& visibility) {
  std::vector<float> depths;
  VisibilityBuffer buffer;
  const std::size_t samples = std::min(kDistanceSamples, cameras.size());
  for (std::size_t i = 0; i < samples; ++i) {
    visibility.trace(cameras[i * cameras.size() / samples].shrunk_to(kDistanceImagePx), buffer);
    std::copy_if(buffer.depth.begin(), buffer.depth.end(), std::back_inserter(depths),
                 [](float depth) { return std::isfinite(depth); });
  }
  if (depths.empty()) {
    throw InputError("none of the cameras sees the mesh (" + std::to_string(samples) + " of " +
                     std::to_string(cameras.size()) + " were asked): give the mesh in the cameras' coordinates");
  }
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return static_cast<double>(*middle);
}

Planner::Planner(Atlas& atlas, const Visibility& visibility, const PlannerOptions& options)
    : atlas_(atlas),
      visibility_(visibility),
      options_(options),
      refiner_(atlas, visibility, options.refinement),
      members_(atlas.surface().cells.cells.size()),
      cells_of_(atlas.capacity()),
      cell_coverage_(atlas.surface().cells.cells.size(), 0),
      loss_(atlas.capacity(), 0) {
  check(options);
  if (atlas.size() != 0) throw std::invalid_argument("planner: the atlas holds views already, must be empty");
}

std::vector<Planner::CellPart> Planner::parts_of(const Camera& camera, Verdict& verdict) {
  const Cells& cells = atlas_.surface().cells;
  // The same image is where refinement chooses its points.
  const Camera small = camera.shrunk_to(sampling_px(std::max(camera.width, camera.height), options_.visibility_px));
  std::vector<CellPixels> seen;
  {
    const Stopwatch stopwatch(verdict.visibility_ms);
    visibility_.trace(small, buffer_);
    seen = count_cell_pixels(buffer_, cells);
  }
  atlas_.mark_seen(seen);
  verdict.cells_seen = static_cast<std::uint32_t>(seen.size());
  std::vector<CellPart> parts;
  parts.reserve(seen.size());
  for (const CellPixels& count : seen) {
    parts.push_back(
        {count.cell, contribution(cells.cells[count.cell], cells.size, small, count.pixels, options_.coverage)});
  }
  return parts;
}

double Planner::coverage_of(std::span<const Member> members, std::optional<std::uint32_t> without_slot) const {
  std::vector<Contribution> views;
  for (const Member& member : members) {
    if (member.referenced && member.slot != without_slot) views.push_back(member.part);
  }
  return set_coverage(views, options_.coverage);
}

Planner::Admission Planner::admit(std::span<const Member> members, const Contribution& part,
                                  std::optional<std::uint32_t> without_slot) const {
  std::vector<Contribution> views;
  std::vector<std::uint32_t> indices;
  for (std::uint32_t i = 0; i < members.size(); ++i) {
    if (members[i].referenced && members[i].slot != without_slot) {
      views.push_back(members[i].part);
      indices.push_back(i);
    }
  }
  const double before = set_coverage(views, options_.coverage);
  views.push_back(part);
  Admission best;
  if (indices.size() < options_.coverage.max_references) {
    best.gain = set_coverage_with_newcomer(views, options_.coverage) - before;
    best.admitted = best.gain > 0;  // section 3.4: while R(b) is not full, Delta_fcov is 0
  } else {
    best.gain = options_.min_reference_gain;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      std::swap(views[i], views[indices.size() - 1]);
      std::vector<Contribution> swapped(views.begin(), views.end() - 2);
      swapped.push_back(part);
      std::swap(views[i], views[indices.size() - 1]);
      const double gain = set_coverage_with_newcomer(swapped, options_.coverage) - before;
      if (gain > best.gain) best = {true, indices[i], gain};
    }
  }
  if (!best.admitted) best.gain = 0;
  return best;
}

// By how much scov rises if the view is added and `victim`, if any, is removed first.
double Planner::gain_of(std::span<const CellPart> parts, std::optional<std::uint32_t> victim) const {
  double gain = victim ? -loss_[*victim] : 0;
  for (const CellPart& entry : parts) gain += admit(members_[entry.cell], entry.part, victim).gain;
  return gain;
}

std::vector<std::uint32_t> Planner::lowest_ranked_slots() const {
  std::vector<std::uint32_t> slots;
  for (std::uint32_t slot = 0; slot < loss_.size(); ++slot) slots.push_back(slot);
  const std::size_t count = std::min<std::size_t>(options_.victims, slots.size());
  std::partial_sort(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(count), slots.end(),
                    [&](std::uint32_t a, std::uint32_t b) { return std::pair(loss_[a], a) < std::pair(loss_[b], b); });
  slots.resize(count);
  return slots;
}

Verdict Planner::offer(const std::string& name, const Camera& camera, Photograph photograph) {
  check(camera);
  Verdict verdict;
  const std::vector<CellPart> parts = parts_of(camera, verdict);
  std::optional<std::uint32_t> victim;
  {
    const Stopwatch stopwatch(verdict.plan_ms);
    if (atlas_.size() < atlas_.capacity()) {
      verdict.gain = gain_of(parts, std::nullopt);
    } else {
      const std::vector<std::uint32_t> candidates = lowest_ranked_slots();
      std::vector<double> gains(candidates.size());
      tbb::parallel_for(std::size_t{0}, candidates.size(),
                        [&](std::size_t i) { gains[i] = gain_of(parts, candidates[i]); });
      const auto best = std::max_element(gains.begin(), gains.end());
      verdict.gain = *best;
      victim = candidates[static_cast<std::size_t>(best - gains.begin())];
    }
  }
  if (!(verdict.gain > options_.min_view_gain * static_cast<double>(parts.size()))) return verdict;

  Camera refined = camera;
  if (options_.refinement.any()) {
    const Stopwatch stopwatch(verdict.refine_ms);
    verdict.refinement = refiner_.refine(camera, photograph, buffer_);
    refined = verdict.refinement->alignment.camera;
    if (verdict.refinement->outlier) {
      verdict.decision = Decision::outlier;
      return verdict;
    }
  }
  const Stopwatch stopwatch(verdict.store_ms);
  StoredView view =
      make_stored_view(name, refined, std::move(photograph), visibility_.trace(refined), options_.validity);
  verdict.decision = victim ? Decision::replaced : Decision::kept;
  if (victim) {
    verdict.replaced = atlas_.view(*victim)->name;
    evict(*victim);
  }
  verdict.slot = atlas_.insert(std::move(view));
  store(*verdict.slot, parts);
  if (verdict.refinement) refiner_.stored(*verdict.slot, camera, *verdict.refinement, options_.validity);
  return verdict;
}

void Planner::store(std::uint32_t slot, std::span<const CellPart> parts) {
  for (const CellPart& entry : parts) {
    std::vector<Member>& members = members_[entry.cell];
    const Admission admission = admit(members, entry.part, std::nullopt);
    if (admission.victim) members[*admission.victim].referenced = false;
    members.push_back({slot, admission.admitted, entry.part});
    cells_of_[slot].push_back(entry.cell);
    publish(entry.cell);
  }
  update_ranks(cells_of_[slot]);
}

void Planner::evict(std::uint32_t slot) {
  const std::vector<std::uint32_t> cells = std::move(cells_of_[slot]);
  cells_of_[slot].clear();
  loss_[slot] = 0;
  for (const std::uint32_t cell : cells) {
    std::vector<Member>& members = members_[cell];
    const auto member = std::find_if(members.begin(), members.end(), [&](const Member& m) { return m.slot == slot; });
    const bool was_referenced = member->referenced;
    members.erase(member);
    if (was_referenced) refill(cell);
    publish(cell);
  }
  refiner_.erased(slot);
  atlas_.erase(slot);
  update_ranks(cells);
}

// Gives a cell that lost a reference the best of the other stored views that see it.
void Planner::refill(std::uint32_t cell) {
  std::vector<Member>& members = members_[cell];
  Admission best;
  Member* choice = nullptr;
  for (Member& member : members) {
    if (member.referenced) continue;
    const Admission admission = admit(members, member.part, std::nullopt);
    if (admission.admitted && admission.gain > best.gain) {
      best = admission;
      choice = &member;
    }
  }
  if (choice) choice->referenced = true;
}

void Planner::publish(std::uint32_t cell) {
  std::vector<std::uint32_t> slots;
  for (const Member& member : members_[cell]) {
    if (member.referenced) slots.push_back(member.slot);
  }
  atlas_.set_references(cell, std::move(slots));
  const double now = coverage_of(members_[cell], std::nullopt);
  summed_coverage_ += now - cell_coverage_[cell];
  cell_coverage_[cell] = now;
}

// Recomputes the rank of every stored view that sees one of the cells.
void Planner::update_ranks(std::span<const std::uint32_t> cells) {
  std::vector<bool> affected(cells_of_.size(), false);
  for (const std::uint32_t cell : cells) {
    for (const Member& member : members_[cell]) affected[member.slot] = true;
  }
  tbb::parallel_for(std::size_t{0}, cells_of_.size(), [&](std::size_t slot) {
    if (!affected[slot]) return;
    double loss = 0;
    for (const std::uint32_t cell : cells_of_[slot]) {
      loss += cell_coverage_[cell] - coverage_of(members_[cell], static_cast<std::uint32_t>(slot));
    }
    loss_[slot] = loss;
  });
}

}  // namespace lumatlas
