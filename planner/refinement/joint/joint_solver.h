// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: poses, exposures and, where they are asked for, lenses and motions of all stored views at once,
// so that they agree at surface points: Levenberg-Marquardt with robust weights, whose steps know how the medians of
// the others move along. Source: Triggs et al. 2000, "Bundle adjustment", section 6. Letters as in joint_problem.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/base/requirement.h"
#include "mesh/cancel_check.h"
#include "planner/refinement/alignment.h"
#include "planner/refinement/joint/joint_cost.h"
#include "planner/refinement/joint/joint_equations.h"
#include "planner/refinement/joint/joint_problem.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

struct JointInput {
  const Atlas& atlas;
  // All three by view slot: the views, the poses that they came with, and the points at which a view is compared with
  // those that a sample's cell refers to.
  std::span<const std::optional<ComparedView>> views;
  std::span<const Camera> given;
  std::span<const std::vector<SurfaceSample>> samples;
};

// Throws std::invalid_argument if there are not as many of each as the atlas has view slots, if a sample's face is not
// in the mesh, or if `most_points` is 0.
void check(const JointInput& input, std::size_t most_points, const Requirement& requires_);
// Throws std::invalid_argument unless the share of the residual by which an estimate must lower it is in (0, 1).
void check_least_improvement(double share, const Requirement& requires_);

struct JointOptions {
  AlignmentOptions alignment;  // its prior and max_move: how strongly poses are pulled to the given ones
  std::size_t most_points;     // points of each view, evenly taken, >= 1
  std::size_t most_operations = kMostStepOperations;  // of a factor, for one step; beyond, equations are not factored
  CancelCheck cancel_check;
};

// The parameters of a lens that are estimated; the others are 0.
using Terms = std::array<bool, kBlock>;

// A step that was kept.
struct JointStep {
  std::uint32_t coarser;  // pyramid levels above the finest one used
  double gain;            // the fall of the sum of squares: robust residuals, pulls and priors; > 0
  double damping;         // 0: the whole step of Gauss and Newton
};

class JointSolver {
 public:
  // The objects that the input refers to must outlive this object. It starts at the views' present poses, with lenses
  // as they are. A view with fewer than kFewestAlignmentPoints points that others show takes no part and stays where it
  // is.
  JointSolver(const JointInput& input, const JointOptions& options);
  JointSolver(const JointSolver&) = delete;
  JointSolver& operator=(const JointSolver&) = delete;

  // Returns for each lens, ascending by the first view slot, the view slots that share it.
  [[nodiscard]] const std::vector<std::vector<ViewSlot>>& slots_of_lenses() const { return slots_of_lenses_; }
  [[nodiscard]] const Camera& camera_of(std::size_t lens) const {
    return state_.cameras[slots_of_lenses_[lens].front()];
  }
  [[nodiscard]] std::size_t views() const;   // that take part
  [[nodiscard]] std::size_t points() const;  // that are fitted to
  [[nodiscard]] std::size_t unknowns() const { return kBlock * blocks_; }
  // Returns whether a factor of the equations may take more than `most` operations on tiles. Makes none to find out.
  [[nodiscard]] bool takes_more_than(std::size_t most) const { return operations_ > most; }

  [[nodiscard]] const JointState& state() const { return state_; }
  void set_state(const JointState& state) { state_ = state; }
  // At first none.
  [[nodiscard]] const Terms& terms(std::size_t lens) const { return terms_[lens]; }
  // A parameter that is no longer estimated becomes 0.
  void set_estimated(std::size_t lens, std::size_t parameter, bool estimated);

  // Estimates the motions of all views too from now on, which are 0 at first.
  void estimate_motions();
  // Returns whether the view has points that are fitted to.
  [[nodiscard]] bool takes_part(ViewSlot slot) const { return !parts_[slot].points.empty(); }

  // Takes the noise of the differences from the present state: what robust weights and residuals are relative to.
  void measure_noise();
  // Takes one step for each round, which says how many pyramid levels above the finest one used it looks at, until one
  // leaves the residual at the finest within 2e-4 of the least so far. A step that does not lower the cost at its level
  // is tried again, shorter, and where that does not help either, the level is left. Leaves the best state of those at
  // the finest level, the present one among them.
  void refine(std::span<const std::uint32_t> rounds);
  // The steps that refine() kept when it was last called.
  [[nodiscard]] const std::vector<JointStep>& steps() const { return steps_; }
  // Roots of the mean robust squared difference, sRGB, at the points that nothing was fitted to: of each lens's views,
  // and of all. 0 where there are none.
  [[nodiscard]] std::vector<double> held_out_residuals() const;
  [[nodiscard]] double held_out_residual() const;
  // Variances of q by lens: see LensEstimate::deviation. Takes a factor of the equations, also where
  // refine() takes none.
  [[nodiscard]] std::vector<Block> variances() const;

 private:
  [[nodiscard]] std::vector<std::size_t> found_lenses();
  void count_operations();
  // Returns the inverse of H times b.
  [[nodiscard]] Eigen::VectorXd solved(const BlockMatrix& H, const Eigen::VectorXd& b) const;
  [[nodiscard]] std::vector<Linearised> linearise(const JointState& state,
                                                  std::vector<ComparedPoint> ViewPart::*points = &ViewPart::points,
                                                  std::uint32_t coarser = 0, bool robust = true) const;
  [[nodiscard]] Eigen::Index column(std::size_t slot) const;
  [[nodiscard]] JointEquations normal_equations(const JointState& state, const std::vector<Linearised>& all) const;
  void add_pulls(const JointState& state, JointEquations& normal) const;
  using PoseBlock = Eigen::Matrix<double, kPose, 1>;
  // A state, and what is linearised there at a level.
  struct Fit {
    JointState state;
    std::vector<Linearised> rows;
  };
  [[nodiscard]] PoseBlock pulled(const JointState& state, ViewSlot slot) const;
  [[nodiscard]] double pull_of(const JointState& state, ViewSlot slot) const;
  [[nodiscard]] Eigen::Index motion_column(std::size_t slot) const;
  [[nodiscard]] double motion_pull_of(const JointState& state, ViewSlot slot) const;
  [[nodiscard]] double prior_cost(const JointState& state) const;
  [[nodiscard]] JointState moved_by(const JointState& from, const Eigen::VectorXd& step) const;
  [[nodiscard]] Fit fit(const JointState& state, std::uint32_t coarser) const;
  [[nodiscard]] double gain_of(const Fit& next, const Fit& now) const;
  // Takes a step that lowers the cost. Returns whether there was one.
  bool improve(Fit& at, std::uint32_t coarser);

  std::span<const std::optional<ComparedView>> views_;
  std::span<const Camera> given_;
  JointOptions options_;
  std::vector<std::vector<ViewSlot>> slots_of_lenses_;
  JointState state_;
  JointProblem problem_;
  const std::vector<ViewPart>& parts_;
  std::vector<Terms> terms_;  // one per lens
  ViewBlocks block_of_;
  std::size_t blocks_ = 0;
  std::size_t operations_ = 0;  // that a factor takes at most, on tiles
  double noise_ = 1;            // deviation of the differences, sRGB
  double damping_ = 0;          // for the next step
  std::vector<JointStep> steps_;
};

}  // namespace lumatlas
