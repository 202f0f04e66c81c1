// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/joint/joint_equations.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::size_t kViewsAtOnce = 32;  // bounds the memory

// The terms of one view's residuals.
struct ViewEquations {
  ViewGradient gradient;
  // For each pair (i, j <= i) of its blocks, one row after the other, the number of its square in `squares`, from 1 on;
  // 0: none. Most pairs of a view that has points in common with hundreds have none.
  std::vector<std::uint32_t> square_of;
  std::vector<BlockSquare> squares;

  // Valid until it is called again.
  [[nodiscard]] BlockSquare& square(std::size_t i, std::size_t j) {
    std::uint32_t& number = square_of[i * (i + 1) / 2 + j];
    if (number == 0) {
      squares.emplace_back(BlockSquare::Zero());
      number = static_cast<std::uint32_t>(squares.size());
    }
    return squares[number - 1];
  }
  // Null where nothing was added to the pair's square.
  [[nodiscard]] const BlockSquare* square_if_any(std::size_t i, std::size_t j) const {
    const std::uint32_t number = square_of[i * (i + 1) / 2 + j];
    return number == 0 ? nullptr : &squares[number - 1];
  }
};

class ViewAdder {
 public:
  ViewAdder(const JointProblem& problem, const JointState& state, const Linearised& linear, ViewSlot slot,
            std::span<const Block> estimated, std::size_t blocks, const ViewBlocks& block_of)
      : problem_(problem),
        state_(state),
        linear_(linear),
        slot_(slot),
        estimated_(estimated),
        block_of_(block_of),
        local_(blocks, 0) {}

  [[nodiscard]] ViewEquations equations() {
    find_blocks();
    const std::vector<ComparedPoint>& points = problem_.parts()[slot_].points;
    for (std::size_t index = 0; index < points.size(); ++index) {
      known_ = 0;
      for (std::size_t row = 3 * index; row < 3 * index + 3; ++row) add_row(row, points[index].position);
    }
    return std::move(out_);
  }

 private:
  void find_blocks() {
    std::vector<std::size_t>& blocks = out_.gradient.blocks;
    const auto has = [&](ViewSlot slot) {
      if (local_[block_of_.own[slot]]++ != 0) return;
      blocks.push_back(block_of_.own[slot]);
      if (has_motions()) blocks.push_back(block_of_.motion[slot]);
      if (local_[problem_.lens_of(slot)]++ == 0) blocks.push_back(problem_.lens_of(slot));
    };
    has(slot_);
    for (const std::array<TargetTerm, 2>& terms : linear_.terms) {
      for (const TargetTerm& term : terms) {
        if (term.gradient != glm::dvec2(0)) has(term.slot);
      }
    }
    std::sort(blocks.begin(), blocks.end());
    for (std::size_t i = 0; i < blocks.size(); ++i) local_[blocks[i]] = i;
    out_.gradient.values.assign(blocks.size(), Block::Zero());
    out_.square_of.assign(blocks.size() * (blocks.size() + 1) / 2, 0);
  }

  void add_row(std::size_t index, const glm::dvec3& position) {
    const auto row = static_cast<Eigen::Index>(index);
    entries_ = 0;
    add_own_entry(slot_, linear_.J.row(row).transpose(), linear_.time[index / 3]);
    add_lens_entry(slot_, linear_.D.row(row).transpose());
    for (const TargetTerm& term : linear_.terms[index]) {
      if (term.gradient == glm::dvec2(0)) continue;
      const ImageDerivatives& seen = derivatives(term.slot, position);
      const Eigen::Vector2d gradient(term.gradient.x, term.gradient.y);
      add_own_entry(term.slot, -seen.by_own.transpose() * gradient, seen.time);
      add_lens_entry(term.slot, -seen.by_lens.transpose() * gradient);
    }
    const double r = linear_.r[row];
    for (std::size_t a = 0; a < entries_; ++a) {
      out_.gradient.values[entry_[a].first] += r * entry_[a].second;
      for (std::size_t b = 0; b < entries_; ++b) {
        if (entry_[b].first > entry_[a].first) continue;
        out_.square(entry_[a].first, entry_[b].first).noalias() += entry_[a].second * entry_[b].second.transpose();
      }
    }
  }

  [[nodiscard]] bool has_motions() const { return !block_of_.motion.empty(); }

  // `time`: at which the view reads the point's line.
  void add_own_entry(ViewSlot slot, const Block& derivative, double time) {
    add_entry(block_of_.own[slot], derivative);
    if (!has_motions()) return;
    Block by_motion = time * derivative;
    by_motion.tail<kBlock - kPose>().setZero();
    add_entry(block_of_.motion[slot], by_motion);
  }

  void add_lens_entry(ViewSlot slot, const Block& derivative) {
    const std::size_t lens = problem_.lens_of(slot);
    add_entry(lens, derivative.cwiseProduct(estimated_[lens]));
  }

  void add_entry(std::size_t block, const Block& derivative) {
    const std::size_t local = local_[block];
    for (std::size_t i = 0; i < entries_; ++i) {
      if (entry_[i].first != local) continue;
      entry_[i].second += derivative;
      return;
    }
    entry_[entries_++] = {local, derivative};
  }

  // The channels of a point mostly have the same views for their medians.
  const ImageDerivatives& derivatives(ViewSlot slot, const glm::dvec3& position) {
    for (std::size_t i = 0; i < known_; ++i) {
      if (derivatives_[i].first == slot) return derivatives_[i].second;
    }
    derivatives_[known_] = {slot, problem_.derivatives(state_, slot, position)};
    return derivatives_[known_++].second;
  }

  const JointProblem& problem_;
  const JointState& state_;
  const Linearised& linear_;
  ViewSlot slot_;
  std::span<const Block> estimated_;
  const ViewBlocks& block_of_;
  std::vector<std::size_t> local_;                      // for each block of the whole problem, the view's block
  std::array<std::pair<std::size_t, Block>, 9> entry_;  // a row's: three views, their motions and lenses at most
  std::size_t entries_ = 0;
  std::array<std::pair<ViewSlot, ImageDerivatives>, 6> derivatives_;  // a point's
  std::size_t known_ = 0;
  ViewEquations out_;
};

void add(const ViewEquations& view, JointEquations& all) {
  const std::vector<std::size_t>& blocks = view.gradient.blocks;
  const auto column = [&](std::size_t i) { return static_cast<Eigen::Index>(kBlock * blocks[i]); };
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    all.g.segment<kBlock>(column(i)) += view.gradient.values[i];
    for (std::size_t j = 0; j <= i; ++j) {
      const BlockSquare* const square = view.square_if_any(i, j);
      if (square != nullptr && !square->isZero(0)) all.H.at(blocks[i], blocks[j]) += *square;
    }
  }
}

using BlockPair = std::pair<std::uint32_t, std::uint32_t>;  // column, row >= column

void sort_without_repetitions(auto& values) {
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
}

// Returns the pairs of blocks that one view's residuals may depend on together.
std::vector<BlockPair> pairs_of_view(const JointProblem& problem, std::size_t slot, const ViewBlocks& block_of) {
  std::vector<BlockPair> pairs;
  std::vector<std::uint32_t> blocks;
  for (const ComparedPoint& point : problem.parts()[slot].points) {
    blocks.clear();
    const auto add_blocks = [&](std::size_t view) {
      blocks.push_back(static_cast<std::uint32_t>(block_of.own[view]));
      if (!block_of.motion.empty()) blocks.push_back(static_cast<std::uint32_t>(block_of.motion[view]));
      blocks.push_back(static_cast<std::uint32_t>(problem.lens_of(view)));
    };
    add_blocks(slot);
    for (const Observation& other : point.others) add_blocks(other.slot);
    sort_without_repetitions(blocks);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      for (std::size_t j = i; j < blocks.size(); ++j) pairs.emplace_back(blocks[i], blocks[j]);
    }
  }
  sort_without_repetitions(pairs);
  return pairs;
}

}  // namespace

BlockPattern joint_pattern(const JointProblem& problem, std::size_t blocks, const ViewBlocks& block_of,
                           const CancelCheck& cancel_check) {
  BlockPattern pattern(blocks);
  for (std::uint32_t block = 0; block < blocks; ++block) pattern[block].push_back(block);
  for (std::size_t slot = 0; slot < problem.parts().size(); ++slot) {
    check_cancelled(cancel_check);
    for (const auto& [column, row] : pairs_of_view(problem, slot, block_of)) pattern[column].push_back(row);
  }
  for (std::vector<std::uint32_t>& rows : pattern) sort_without_repetitions(rows);
  return pattern;
}

JointEquations joint_equations(const JointProblem& problem, const JointState& state,
                               const std::vector<Linearised>& linear, std::span<const Block> estimated,
                               std::size_t blocks, const ViewBlocks& block_of, const CancelCheck& cancel_check) {
  const auto unknowns = static_cast<Eigen::Index>(kBlock * blocks);
  JointEquations all{BlockMatrix(blocks), Eigen::VectorXd::Zero(unknowns), std::vector<ViewGradient>(linear.size())};
  for (std::size_t first = 0; first < linear.size(); first += kViewsAtOnce) {
    std::vector<ViewEquations> views(std::min(kViewsAtOnce, linear.size() - first));
    tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) {
      if (linear[first + i].terms.empty()) return;
      check_cancelled(cancel_check);
      const ViewSlot slot(static_cast<std::uint32_t>(first + i));
      views[i] = ViewAdder(problem, state, linear[slot], slot, estimated, blocks, block_of).equations();
    });
    for (std::size_t i = 0; i < views.size(); ++i) {
      add(views[i], all);
      all.of_views[first + i] = std::move(views[i].gradient);
    }
  }
  return all;
}

}  // namespace lumatlas
