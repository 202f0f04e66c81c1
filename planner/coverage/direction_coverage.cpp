// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/coverage/direction_coverage.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>

#include "mesh/base/requirement.h"

namespace lumatlas {

namespace {

// The golden angle: points at multiples of it around a circle never line up.
const double kGoldenAngle = glm::pi<double>() * (3 - std::sqrt(5.0));

// A unit vector at right angles to `normal`, near `wish` if that is not along it.
glm::dvec3 tangent_near(const glm::dvec3& normal, const glm::dvec3& wish) {
  const glm::dvec3 tangent = wish - glm::dot(wish, normal) * normal;
  const double length = glm::length(tangent);
  if (length > 1e-6 * glm::length(wish)) return tangent / length;
  const glm::dvec3 axis = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(normal, axis));
}

CellFrame frame(const Cell& cell, const glm::dvec3& wish) {
  if (cell.normal == glm::dvec3(0)) return {glm::dmat3(1), true};
  const glm::dvec3 tangent = tangent_near(cell.normal, wish);
  return {glm::transpose(glm::dmat3(tangent, glm::cross(cell.normal, tangent), cell.normal)), false};
}

}  // namespace

std::vector<CellFrame> cell_frames(const Surface& surface) {
  // The tangent points at a corner of the cell's first face, so that it turns with the mesh.
  const std::vector<Cell>& cells = surface.cells.cells;
  std::vector<glm::dvec3> corners(cells.size(), glm::dvec3(0));
  std::vector<std::uint8_t> known(cells.size(), 0);
  for (std::size_t face = 0; face < surface.cells.cell_of_face.size(); ++face) {
    const CellId cell = surface.cells.cell_of_face[face];
    if (known[cell] != 0) continue;
    known[cell] = 1;
    corners[cell] = glm::dvec3(surface.mesh.positions[surface.mesh.faces[face].x]);
  }
  std::vector<CellFrame> frames;
  frames.reserve(cells.size());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    frames.push_back(frame(cells[cell], corners[cell] - cells[cell].centroid));
  }
  return frames;
}

std::vector<glm::vec3> novel_directions(std::uint32_t count, bool two_sided) {
  constexpr Requirement direction_coverage_requires{"coverage"};
  direction_coverage_requires(count >= 1, "count", count, "at least 1");
  std::vector<glm::vec3> directions;
  directions.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double share = (i + 0.5) / count;
    // Evenly over the sphere, or evenly over the disk below the hemisphere, which makes them as dense as cos of the
    // angle to the normal.
    const double z = two_sided ? 1 - 2 * share : std::sqrt(1 - share);
    const double radius = std::sqrt(1 - z * z);
    directions.emplace_back(radius * std::cos(i * kGoldenAngle), radius * std::sin(i * kGoldenAngle), z);
  }
  return directions;
}

DirectionCoverage::Kernel::Kernel(double lambda_share, double width)
    : lambda(static_cast<float>(lambda_share)),
      cosine_scale(static_cast<float>(std::min(1 / (1 - std::cos(glm::radians(width))), 1e30))) {}

DirectionCoverage::DirectionCoverage(const Surface& surface, const CoverageOptions& options, double min_reference_gain)
    : CellCoverage(surface.cells.cells.size(), options, min_reference_gain),
      options_(options),
      min_reference_gain_(min_reference_gain),
      value_kernel_(options.lambda, options.direction_width),
      reference_kernel_(options.reference_lambda, options.reference_width),
      kept_(options.views_per_direction + 1),
      direction_share_(1.0 / options.directions),
      above_(novel_directions(options.directions, false)),
      around_(novel_directions(options.directions, true)),
      frames_(cell_frames(surface)),
      cells_(frames_.size(), empty_state()) {
  const float sum = 2 - std::ldexp(1.0f, 1 - static_cast<int>(options.views_per_direction));
  for (std::uint32_t j = 0; j < options.views_per_direction; ++j) {
    rank_value_.push_back(std::ldexp(1.0f, -static_cast<int>(j)) / sum);
  }
}

// The state of a cell that no offered view has seen yet.
DirectionCoverage::State DirectionCoverage::empty_state() const {
  State state;
  state.weight = options_.demand ? 0 : 1;
  state.ideal_distance = options_.demand ? 0 : options_.ideal_distance;
  return state;
}

// cov_p at the cell's ideal distance. It is computed from the member's stored single-precision values alone, so that it
// is the same whenever it is computed again.
float DirectionCoverage::positional(CellId cell, const Member& member) const {
  const double ideal_distance = cells_[cell].ideal_distance;
  if (!(ideal_distance > 0)) return 0;
  return static_cast<float>(positional_coverage(static_cast<double>(member.distance),
                                                static_cast<double>(member.cell_share), ideal_distance, options_));
}

DirectionCoverage::Member DirectionCoverage::member(CellId cell, ViewSlot slot, const Contribution& part) const {
  Member member{slot,
                glm::vec3(frames_[cell].cell_from_world * part.direction),
                static_cast<float>(part.distance),
                static_cast<float>(part.cell_share),
                static_cast<float>(part.positional),
                false,
                false};
  if (options_.demand) member.positional = positional(cell, member);
  return member;
}

DirectionCoverage::Directions::Directions(const std::vector<glm::vec3>& directions) {
  for (const glm::vec3& direction : directions) {
    x.push_back(direction.x);
    y.push_back(direction.y);
    z.push_back(direction.z);
  }
}

const DirectionCoverage::Directions& DirectionCoverage::novel(CellId cell) const {
  return frames_[cell].two_sided ? around_ : above_;
}

// Computes q(f, s) for each novel direction s.
void DirectionCoverage::qualities(CellId cell, const Member& member, const Kernel& kernel,
                                  std::vector<float>& quality_by_direction) const {
  using Values = Eigen::ArrayXf;
  const Directions& directions = novel(cell);
  const auto along = [&](const std::vector<float>& coordinates) {
    return Eigen::Map<const Values>(coordinates.data(), static_cast<Eigen::Index>(coordinates.size()));
  };
  quality_by_direction.resize(directions.x.size());
  // Several short loops, because one expression of all takes longer to set up than they do.
  Eigen::Map<Values> values(quality_by_direction.data(), static_cast<Eigen::Index>(quality_by_direction.size()));
  values = member.direction.x * along(directions.x);
  values += member.direction.y * along(directions.y);
  values += member.direction.z * along(directions.z);
  // Rounding can make the cosine exceed 1, by much where the width is small.
  values = 1 - (1 - values) * kernel.cosine_scale;
  values = values.max(0.0f).min(1.0f);
  values = member.positional * (kernel.lambda * values + 1 - kernel.lambda);
}

// Returns by how much a view of that quality would raise the value of one direction, whose best views are `best`.
double DirectionCoverage::rise(std::span<const Served> best, float quality) const {
  const std::size_t ranks = rank_value_.size();
  std::size_t j = 0;
  while (j < ranks && quality <= best[j].quality) ++j;
  double sum = 0;
  float displacing = quality;
  for (; j < ranks; ++j) {
    sum += rank_value_[j] * (displacing - best[j].quality);
    displacing = best[j].quality;
  }
  return sum;
}

// Puts a view in its rank among the best; the last one drops out.
void DirectionCoverage::admit(std::span<Served> best, Served newcomer) const {
  if (newcomer.quality <= best.back().quality) return;
  for (Served& served : best) {
    if (newcomer.quality > served.quality) std::swap(served, newcomer);
  }
}

// For each direction, the best K + 1 of the members for which is_wanted() holds.
template <typename Wanted>
std::vector<DirectionCoverage::Served> DirectionCoverage::best_of(CellId cell, const Kernel& kernel,
                                                                  const Wanted& is_wanted) const {
  std::vector<Served> best(options_.directions * kept_);
  std::vector<float> quality;
  for (const Member& member : cells_[cell].members) {
    if (!is_wanted(member)) continue;
    qualities(cell, member, kernel, quality);
    for (std::size_t s = 0; s < quality.size(); ++s) {
      admit(std::span(best).subspan(s * kept_, kept_), {quality[s], member.slot});
    }
  }
  return best;
}

double DirectionCoverage::value_of(std::span<const Served> best) const {
  double sum = 0;
  for (std::size_t first = 0; first < best.size(); first += kept_) {
    for (std::size_t j = 0; j < rank_value_.size(); ++j) sum += rank_value_[j] * best[first + j].quality;
  }
  return sum / options_.directions;
}

// Returns `factor` times the rise of the value that a view of these qualities would bring. To the entry of each slot in
// `corrections` it adds by how much that would differ if the slot's view had left before.
double DirectionCoverage::gain_over(std::span<const Served> best, std::span<const float> quality, double factor,
                                    std::span<double> corrections) const {
  const double scale = factor / options_.directions;
  if (best.empty()) {
    double sum = 0;
    for (const float q : quality) sum += rank_value_[0] * q;
    return scale * sum;
  }
  double sum = 0;
  const std::size_t ranks = rank_value_.size();
  std::array<Served, CoverageOptions::kMostViewsPerDirection> others;
  for (std::size_t s = 0; s < quality.size(); ++s) {
    const std::span<const Served> served = best.subspan(s * kept_, kept_);
    if (quality[s] <= served[ranks].quality) continue;  // it would not matter even if one of them had left
    const double gain = rise(served, quality[s]);
    sum += gain;
    if (corrections.empty()) continue;
    std::copy(served.begin() + 1, served.end(), others.begin());
    for (std::size_t j = 0; j < ranks && served[j].slot != ViewSlot::none; ++j) {
      // `others` is `served` without its j-th.
      corrections[served[j].slot] += scale * (rise(std::span(others).first(ranks), quality[s]) - gain);
      others[j] = served[j];
    }
  }
  return scale * sum;
}

void DirectionCoverage::losses_of(std::span<const Served> best, double factor, std::span<double> losses) const {
  if (losses.empty()) return;  // the caller needs no losses
  const double share = factor * direction_share_;
  for (std::size_t first = 0; first < best.size(); first += kept_) {
    double loss = 0;  // if the j-th leaves, those behind it move up by one rank
    for (std::size_t j = rank_value_.size(); j-- > 0;) {
      loss += rank_value_[j] * (best[first + j].quality - best[first + j + 1].quality);
      if (best[first + j].slot != ViewSlot::none) losses[best[first + j].slot] += share * loss;
    }
  }
}

double DirectionCoverage::do_gain(CellId cell, const Contribution& part, std::span<const std::uint8_t>,
                                  std::span<double> corrections) const {
  thread_local std::vector<float> quality;
  qualities(cell, member(cell, ViewSlot::none, part), value_kernel_, quality);
  return gain_over(cells_[cell].best, quality, cells_[cell].weight, corrections);
}

double DirectionCoverage::do_value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                                 const Contribution* newcomer) const {
  std::vector<Served> best = best_of(cell, value_kernel_, [&](const Member& member) {
    return std::find(gone.begin(), gone.end(), member.slot) == gone.end();
  });
  if (newcomer) {
    std::vector<float> quality;
    qualities(cell, member(cell, ViewSlot::none, *newcomer), value_kernel_, quality);
    for (std::size_t s = 0; s < quality.size(); ++s) {
      admit(std::span(best).subspan(s * kept_, kept_), {quality[s], ViewSlot::none});
    }
  }
  return cells_[cell].weight * value_of(best);
}

double DirectionCoverage::do_change_demand(CellId cell, const Contribution& part, DemandChange change,
                                           std::span<double> losses) {
  State& state = cells_[cell];
  const double value_before = value(cell), weight_before = state.weight;
  change == DemandChange::remove ? state.demand.remove(part) : state.demand.add(part);
  state.weight = state.demand.weight(options_.demand_prior);
  const double ideal_distance = state.demand.ideal_distance();
  if (ideal_distance == state.ideal_distance) {
    losses_of(state.best, state.weight - weight_before, losses);
  } else {
    state.ideal_distance = ideal_distance;
    losses_of(state.best, -weight_before, losses);
    follow_demand(cell);
    losses_of(state.best, state.weight, losses);
  }
  return value(cell) - value_before;
}

// Computes anew what depends on the cell's ideal distance, which has changed.
void DirectionCoverage::follow_demand(CellId cell) {
  State& state = cells_[cell];
  if (state.members.empty()) return;
  for (Member& member : state.members) member.positional = positional(cell, member);
  state.best = best_of(cell, value_kernel_, [](const Member&) { return true; });
  state.value = value_of(state.best);
}

void DirectionCoverage::do_insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) {
  State& state = cells_[cell];
  state.members.push_back(member(cell, slot, part));
  state.best.resize(options_.directions * kept_);
  thread_local std::vector<float> quality;
  qualities(cell, state.members.back(), value_kernel_, quality);
  for (std::size_t s = 0; s < quality.size(); ++s) {
    const std::span<Served> served = std::span(state.best).subspan(s * kept_, kept_);
    if (quality[s] <= served.back().quality) continue;
    losses_of(served, -state.weight, losses);
    admit(served, {quality[s], slot});
    losses_of(served, state.weight, losses);
  }
  state.value = value_of(state.best);
  if (keeps_references_) reference_newest(cell);
}

void DirectionCoverage::do_erase(CellId cell, ViewSlot slot, std::span<double> losses) {
  State& state = cells_[cell];
  const auto member = std::find_if(state.members.begin(), state.members.end(),
                                   [&](const Member& candidate) { return candidate.slot == slot; });
  const bool was_referenced = member->referenced;
  state.members.erase(member);
  serve_without(cell, slot, losses);
  state.value = value_of(state.best);
  if (was_referenced) refill(cell);
}

bool DirectionCoverage::is_member(CellId cell, ViewSlot slot) const {
  const std::vector<Member>& members = cells_[cell].members;
  return std::any_of(members.begin(), members.end(), [&](const Member& member) { return member.slot == slot; });
}

void DirectionCoverage::forget_references() {
  keeps_references_ = false;
  for (State& state : cells_) {
    for (Member& member : state.members) member.referenced = member.given_up = false;
  }
}

void DirectionCoverage::forget_idle(CellId cell) {
  require_cell(cell);
  State& state = cells_[cell];
  std::vector<std::uint32_t> serving;
  for (const Served& served : state.best) serving.push_back(served.slot);
  std::sort(serving.begin(), serving.end());
  std::erase_if(state.members,
                [&](const Member& member) { return !std::binary_search(serving.begin(), serving.end(), member.slot); });
}

// Gives each direction that the member in `slot`, which has left, was among the best of, the next best member instead.
void DirectionCoverage::serve_without(CellId cell, ViewSlot slot, std::span<double> losses) {
  State& state = cells_[cell];
  const auto served_in = [&](std::size_t s) { return std::span(state.best).subspan(s * kept_, kept_); };
  thread_local std::vector<std::size_t> left;
  left.clear();
  for (std::size_t s = 0; s < options_.directions; ++s) {
    const std::span<Served> served = served_in(s);
    const auto gone = std::find_if(served.begin(), served.end(), [&](const Served& view) { return view.slot == slot; });
    if (gone == served.end()) continue;
    losses_of(served, -state.weight, losses);
    std::rotate(gone, gone + 1, served.end());
    served.back() = {};
    left.push_back(s);
  }
  thread_local std::vector<float> quality;
  for (const Member& member : state.members) {
    if (left.empty()) break;
    qualities(cell, member, value_kernel_, quality);
    for (const std::size_t s : left) {
      const std::span<Served> served = served_in(s);
      if (quality[s] <= served.back().quality) continue;
      const bool is_served =
          std::any_of(served.begin(), served.end() - 1, [&](const Served& view) { return view.slot == member.slot; });
      if (!is_served) served.back() = {quality[s], member.slot};
    }
  }
  for (const std::size_t s : left) losses_of(served_in(s), state.weight, losses);
  if (state.members.empty()) state.best.clear();
}

// Section 3.4: a view takes a free place, or that of the reference whose leaving for it gains most.
void DirectionCoverage::reference_newest(CellId cell) {
  std::vector<Member>& members = cells_[cell].members;
  Member& newest = members.back();
  if (!(newest.positional > 0)) return;
  const auto references = std::count_if(members.begin(), members.end(), [](const Member& m) { return m.referenced; });
  if (static_cast<std::size_t>(references) < options_.max_references) {
    newest.referenced = true;
    return;
  }
  const std::vector<Served> best =
      best_of(cell, reference_kernel_, [](const Member& member) { return member.referenced; });
  std::vector<float> quality;
  qualities(cell, newest, reference_kernel_, quality);
  std::vector<double> exchange(
      std::max_element(members.begin(), members.end(), [](const Member& a, const Member& b) { return a.slot < b.slot; })
          ->slot +
      std::size_t{1});
  const double gain = gain_over(best, quality, 1, exchange);
  losses_of(best, -1, exchange);
  Member* victim = nullptr;
  for (Member& member : members) {
    if (member.referenced && (!victim || exchange[member.slot] > exchange[victim->slot])) victim = &member;
  }
  if (!(gain + exchange[victim->slot] > min_reference_gain_)) return;
  victim->referenced = false;
  victim->given_up = false;
  newest.referenced = true;
}

// Gives a cell that lost a reference the best of the other stored views that see it.
void DirectionCoverage::refill(CellId cell) {
  std::vector<Member>& members = cells_[cell].members;
  if (std::all_of(members.begin(), members.end(), [](const Member& m) { return m.referenced; })) return;
  const std::vector<Served> best =
      best_of(cell, reference_kernel_, [](const Member& member) { return member.referenced; });
  std::vector<float> quality;
  Member* choice = nullptr;
  double most = -1;
  for (Member& member : members) {
    if (member.referenced || !(member.positional > 0)) continue;
    qualities(cell, member, reference_kernel_, quality);
    const double gain = gain_over(best, quality, 1, {});
    if (gain > most) {
      most = gain;
      choice = &member;
    }
  }
  if (!choice) return;
  choice->referenced = true;
  choice->given_up = false;
}

std::vector<ViewSlot> DirectionCoverage::do_references(CellId cell) const {
  std::vector<ViewSlot> slots;
  for (const Member& member : cells_[cell].members) {
    if (member.referenced) slots.push_back(member.slot);
  }
  return slots;
}

// p(f, c) of a member for the direction of each member.
std::vector<float> DirectionCoverage::camera_qualities(CellId cell, const Member& member) const {
  const float lambda = static_cast<float>(options_.lambda);
  const float width = static_cast<float>(glm::radians(options_.direction_width));
  std::vector<float> quality;
  quality.reserve(cells_[cell].members.size());
  for (const Member& camera : cells_[cell].members) {
    const float angle = std::acos(std::clamp(glm::dot(member.direction, camera.direction), -1.0f, 1.0f));
    quality.push_back(member.positional * (lambda * std::max(0.0f, 1 - angle / width) + 1 - lambda));
  }
  return quality;
}

// For the direction of each camera, the best K + 1 of the references whose qualities are given, of which there is at
// least one. Their slots are places in `qualities`.
std::vector<DirectionCoverage::Served> DirectionCoverage::best_for_cameras(
    std::span<const std::vector<float>> qualities) const {
  std::vector<Served> best(qualities.front().size() * kept_);
  for (std::uint32_t i = 0; i < qualities.size(); ++i) {
    for (std::size_t c = 0; c < qualities[i].size(); ++c) {
      admit(std::span(best).subspan(c * kept_, kept_), {qualities[i][c], ViewSlot{i}});
    }
  }
  return best;
}

double DirectionCoverage::service(CellId cell, std::span<const Member* const> references) const {
  if (references.empty()) return 0;
  std::vector<std::vector<float>> qualities;
  for (const Member* reference : references) qualities.push_back(camera_qualities(cell, *reference));
  const double directions = options_.directions, cameras = static_cast<double>(cells_[cell].members.size());
  return cells_[cell].weight * value_of(best_for_cameras(qualities)) * directions / cameras;
}

std::vector<ReferenceLoss> DirectionCoverage::do_reference_losses(CellId cell) const {
  const State& state = cells_[cell];
  std::vector<ViewSlot> left = references(cell);
  std::vector<std::vector<float>> qualities;
  for (const Member& member : state.members) {
    if (member.referenced) qualities.push_back(camera_qualities(cell, member));
  }
  std::vector<ReferenceLoss> order;
  while (left.size() > rank_value_.size()) {
    std::vector<double> losses(left.size());
    losses_of(best_for_cameras(qualities), state.weight * options_.directions, losses);
    const auto least = std::min_element(losses.begin(), losses.end()) - losses.begin();
    const auto place = static_cast<std::size_t>(least);
    order.push_back({left[place], std::max(0.0, losses[place]) / static_cast<double>(state.members.size())});
    left.erase(left.begin() + least);
    qualities.erase(qualities.begin() + least);
  }
  return order;
}

void DirectionCoverage::do_give_up(CellId cell, std::span<const ViewSlot> slots) {
  for (Member& member : cells_[cell].members) {
    if (!member.referenced || std::find(slots.begin(), slots.end(), member.slot) == slots.end()) continue;
    member.referenced = false;
    member.given_up = true;
  }
}

ReferenceService DirectionCoverage::do_reference_service(CellId cell) const {
  ReferenceService result;
  std::vector<const Member*> kept, all;
  for (const Member& member : cells_[cell].members) {
    if (member.referenced) kept.push_back(&member);
    if (member.referenced || member.given_up) all.push_back(&member);
  }
  result.of_kept = service(cell, kept);
  result.of_all = kept.size() == all.size() ? result.of_kept : service(cell, all);
  result.given_up = static_cast<std::uint32_t>(all.size() - kept.size());
  return result;
}

void DirectionCoverage::do_follow(const Surface& surface, std::span<const CellId> previous_cell) {
  std::vector<CellFrame> frames = cell_frames(surface);
  std::vector<State> cells(previous_cell.size(), empty_state());
  for (std::size_t cell = 0; cell < cells.size(); ++cell) {
    if (previous_cell[cell] == CellId::none) continue;
    cells[cell] = std::move(cells_[previous_cell[cell]]);
    frames[cell] = frames_[previous_cell[cell]];  // the directions of its members are given in that frame
  }
  cells_ = std::move(cells);
  frames_ = std::move(frames);
}

}  // namespace lumatlas
