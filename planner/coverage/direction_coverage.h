// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how well the views that see a cell serve the novel directions above it, as the renderer will need them. It
// replaces the sum over views of Erat et al. 2019, section 3.2.
//
//   q(f, s)    = cov_p(f) (lambda k(f, s) + 1 - lambda)       how well view f serves novel direction s, in [0, 1]
//   k(f, s)    = max(0, 1 - (1 - cos angle(f, s)) / (1 - cos direction_width))
//   value(b)   = w(b) mean over the cell's novel directions s of  sum_j v_j q_j(s)   in [0, w(b)]
//
// where q_1(s) >= q_2(s) >= ... are the K = views_per_direction best of q(f, s) over the views, and v_j halves from one
// to the next and sums to 1. The weight w(b), in [0, 1], and the d_max of cov_p are the demand of the cell
// (cell_demand.h). Without demand, w(b) is 1 and d_max the same for all cells. The novel directions are spread over the
// hemisphere above the cell in proportion to the area that the cell shows to them; over the sphere where the cell has
// no mean normal.
//
// A set of views in a different order is worth the same, a view more never makes it worth less, and what a view adds
// falls as others come: with the same demand value(), and so scov, is monotone submodular. For such a measure greedy
// selection offline reaches 1 - 1/e of the optimum (Nemhauser et al. 1978). Online selection with exchanges reaches a
// quarter of it (Buchbinder, Feldman, Schwartz 2015) under four conditions. An exchange must gain scov / N
// (PlannerOptions::min_exchange_gain). Any view with a gain is taken while there is room. Views are bounded by number
// alone. The measure does not change, as it does not without demand.
//
// All stored views that see a cell count, not its references alone. Those are chosen by the same measure with a
// narrower k of more weight (reference_width, reference_lambda), since the renderer looks for the nearest directions
// among them: a newcomer takes the place of the reference whose loss costs least.
//
// The cost of removing a reference is judged at the stored cameras that see the cell, where pictures will be wanted:
//
//   service(b) = w(b) mean over these cameras' directions c of  sum_j v_j p_j(c)
//   p(f, c)    = cov_p(f) (lambda max(0, 1 - angle(f, c) / direction_width) + 1 - lambda)
//
// It falls at once with the angle, as parallax does where the mesh is wrong; q is flat around 0, and lets go of the
// nearest view where others are nearly as near (planner/README.md).
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "mesh/base/id.h"
#include "planner/coverage/cell_coverage.h"
#include "planner/coverage/cell_demand.h"

namespace lumatlas {

// Rows: two tangents and the normal of a cell, or any axes where it has none; turns with the mesh.
struct CellFrame {
  glm::dmat3 cell_from_world{1.0};
  bool two_sided = false;  // no mean normal: seen from everywhere
};

[[nodiscard]] std::vector<CellFrame> cell_frames(const Surface& surface);

// Unit directions in a cell's frame, spread as described above; `count` >= 1 (std::invalid_argument).
[[nodiscard]] std::vector<glm::vec3> novel_directions(std::uint32_t count, bool two_sided);

class DirectionCoverage final : public CellCoverage {
 public:
  // Like make_cell_coverage(). `min_reference_gain` is in cells.
  DirectionCoverage(const Surface& surface, const CoverageOptions& options, double min_reference_gain);

  [[nodiscard]] std::unique_ptr<CellCoverage> copy() const override {
    return std::make_unique<DirectionCoverage>(*this);
  }

  void forget_references() override;

  // Forgets the members that are among the best K + 1 of no direction, which changes no value: at most
  // (K + 1) * CoverageOptions::directions are left. What they would be worth at another ideal distance is lost.
  void forget_idle(CellId cell);
  [[nodiscard]] std::size_t member_count(CellId cell) const {
    require_cell(cell);
    return cells_[cell].members.size();
  }

 private:
  [[nodiscard]] double do_value(CellId cell) const override { return cells_[cell].weight * cells_[cell].value; }
  [[nodiscard]] double do_gain(CellId cell, const Contribution& part, std::span<const std::uint8_t> victims,
                               std::span<double> corrections) const override;
  [[nodiscard]] double do_value_by_definition(CellId cell, std::span<const ViewSlot> gone,
                                              const Contribution* newcomer) const override;
  double do_change_demand(CellId cell, const Contribution& part, DemandChange change,
                          std::span<double> losses) override;
  [[nodiscard]] double do_weight(CellId cell) const override { return cells_[cell].weight; }
  void do_insert(CellId cell, ViewSlot slot, const Contribution& part, std::span<double> losses) override;
  void do_erase(CellId cell, ViewSlot slot, std::span<double> losses) override;
  [[nodiscard]] std::vector<ViewSlot> do_references(CellId cell) const override;
  [[nodiscard]] std::vector<ReferenceLoss> do_reference_losses(CellId cell) const override;
  void do_give_up(CellId cell, std::span<const ViewSlot> slots) override;
  [[nodiscard]] ReferenceService do_reference_service(CellId cell) const override;
  void do_follow(const Surface& surface, std::span<const CellId> previous_cell) override;
  [[nodiscard]] bool is_member(CellId cell, ViewSlot slot) const override;

  struct Member {
    ViewSlot slot;
    glm::vec3 direction;  // in the cell's frame
    float distance, cell_share;
    float positional;  // at the cell's ideal distance
    bool referenced;
    bool given_up;  // was referenced, until give_up()
  };
  struct Served {
    float quality = 0;
    ViewSlot slot;
  };
  struct State {
    std::vector<Member> members;
    // The best K + 1 views of each novel direction, best first; empty until a view sees the cell.
    std::vector<Served> best;
    double value = 0;  // before the weight
    CellDemand demand;
    double weight = 0;
    double ideal_distance = 0;
  };
  [[nodiscard]] State empty_state() const;
  [[nodiscard]] float positional(CellId cell, const Member& member) const;
  void follow_demand(CellId cell);
  [[nodiscard]] Member member(CellId cell, ViewSlot slot, const Contribution& part) const;
  // Unit vectors, each coordinate apart, so that a processor works on several at once.
  struct Directions {
    explicit Directions(const std::vector<glm::vec3>& directions);
    std::vector<float> x, y, z;
  };
  [[nodiscard]] const Directions& novel(CellId cell) const;
  // lambda and direction_width, of the value or of the choice of references.
  struct Kernel {
    Kernel(double lambda_share, double width);
    float lambda;
    float cosine_scale;  // 1 / (1 - cos width)
  };
  void qualities(CellId cell, const Member& member, const Kernel& kernel, std::vector<float>& quality) const;
  // Both work on one novel direction, whose K + 1, or K, best views are `best`.
  [[nodiscard]] double rise(std::span<const Served> best, float quality) const;
  void admit(std::span<Served> best, Served newcomer) const;
  template <typename Wanted>
  [[nodiscard]] std::vector<Served> best_of(CellId cell, const Kernel& kernel, const Wanted& is_wanted) const;
  [[nodiscard]] double value_of(std::span<const Served> best) const;
  [[nodiscard]] double gain_over(std::span<const Served> best, std::span<const float> quality, double factor,
                                 std::span<double> corrections) const;
  void losses_of(std::span<const Served> best, double factor, std::span<double> losses) const;
  void serve_without(CellId cell, ViewSlot slot, std::span<double> losses);
  void reference_newest(CellId cell);
  void refill(CellId cell);
  [[nodiscard]] std::vector<float> camera_qualities(CellId cell, const Member& member) const;
  [[nodiscard]] std::vector<Served> best_for_cameras(std::span<const std::vector<float>> qualities) const;
  [[nodiscard]] double service(CellId cell, std::span<const Member* const> references) const;

  CoverageOptions options_;
  double min_reference_gain_;
  bool keeps_references_ = true;  // false after forget_references()
  Kernel value_kernel_, reference_kernel_;
  std::size_t kept_;               // K + 1
  double direction_share_;         // of one novel direction in the mean
  std::vector<float> rank_value_;  // v_j
  Directions above_;               // novel directions of a cell with a normal,
  Directions around_;              // and of one without
  std::vector<CellFrame> frames_;
  std::vector<State> cells_;
};

}  // namespace lumatlas
