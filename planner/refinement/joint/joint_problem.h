// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to planner/: how the stored views disagree at surface points, as a function of their lenses, poses and
// exposures.
//
// Letters: q a lens's parameters (ln focal, shift x and y in image widths, k1, k2, p1, p2); p a view's own (rotation
// vector, translation in median depths, ln gain); m its motion while the shutter reads it (turn, shift in median
// depths, 0); r residuals, J = dr/dp, D = dr/dq of the view's own lens; t when a point's line is read.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/lens_correction.h"
#include "mesh/camera/shutter_motion.h"
#include "mesh/cancel_check.h"
#include "planner/refinement/joint/block_matrix.h"
#include "planner/refinement/median_colors.h"
#include "planner/refinement/surface_samples.h"

namespace lumatlas {

inline constexpr int kPose = 6;  // parameters of a view's pose, before its gain

[[nodiscard]] LensCorrection correction_of(const Block& q);
[[nodiscard]] ShutterMotion motion_of(const Block& m, double depth);

// Another view that shows a point.
struct Observation {
  ViewSlot slot;
  double level;  // the pyramid level whose pixels are as large on the surface as the own photograph's at level 0
};

struct ComparedPoint {
  glm::dvec3 position;
  std::vector<Observation> others;
};

// The parts of a view that do not change.
struct ViewPart {
  std::vector<ComparedPoint> points;    // that are fitted to
  std::vector<ComparedPoint> held_out;  // points that judge the fit
  double depth = 1;                     // median of the points
  std::uint32_t level = 0;              // the finest that is used
};
// and what is refined.
struct JointState {
  std::vector<Block> lens_parameters;  // one per lens
  std::vector<Camera> cameras;         // one per view slot, with the given intrinsics
  // One per view slot: a factor on the view's gain where it is compared with the others' colours. Those colours have
  // the gains that the views came with; otherwise the differences would fall if all views grew darker. Free gains with
  // a fixed mean left poses as far from the truth (walks of 24 views, 3 pixels of error, up to a stop of exposure).
  std::vector<double> gain;
  std::vector<Block> motion;  // one per view slot: m
};

// One term of a target's derivative: d target / d image of the view that gives the median.
struct TargetTerm {
  ViewSlot slot{0};
  glm::dvec2 gradient{0.0};
};

// A view's residuals: three rows for each of its points.
struct Linearised {
  Eigen::VectorXd r;
  BlockRows J;
  BlockRows D;                                   // at fixed targets
  std::vector<std::array<TargetTerm, 2>> terms;  // one per row: d r / d image, to be subtracted
  std::vector<double> time;                      // one per point: dr/dm = t dr/d pose
  // For each point, whether both the view and another one show it. If not, the residuals are those of an outlier.
  std::vector<bool> compared;
};

// Derivatives of the pixel at which a view sees a point by its lens and its pose; the last column of `by_own` is 0.
// Those by its motion are `time` times those by its pose.
struct ImageDerivatives {
  Eigen::Matrix<double, 2, kBlock> by_lens;
  Eigen::Matrix<double, 2, kBlock> by_own;
  double time = 0;
};

class JointProblem {
 public:
  // See JointInput. `lens_of` by view slot. What the spans show must outlive this object.
  JointProblem(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
               std::span<const std::vector<SurfaceSample>> samples, std::vector<std::size_t> lens_of,
               std::size_t most_points, CancelCheck cancel_check);

  [[nodiscard]] const std::vector<ViewPart>& parts() const {
    return parts_;
  }  // one per view slot; no points: it takes no part
  [[nodiscard]] bool has_view(std::size_t slot) const { return views_[slot].has_value(); }
  [[nodiscard]] std::size_t lens_of(std::size_t slot) const { return lens_of_[slot]; }

  // Returns the linearised residuals by view slot, for the points that are fitted to or those held out, `coarser`
  // levels above the finest that is used. `noise`: of the differences, sRGB.
  [[nodiscard]] std::vector<Linearised> linearise(const JointState& state, std::vector<ComparedPoint> ViewPart::*points,
                                                  std::uint32_t coarser, double noise, bool robust) const;
  [[nodiscard]] ImageDerivatives derivatives(const JointState& state, ViewSlot slot, const glm::dvec3& position) const;

 private:
  // The values at which the state is linearised.
  struct Linearisation {
    const JointState& state;
    std::vector<LensCorrection> corrections;  // one per lens
    std::vector<ShutterMotion> motions;       // one per view slot
    std::uint32_t coarser;
    double noise;
    bool robust;
  };
  // The view that also shows a point, and the level of its pyramid.
  struct SampledView {
    ViewSlot slot;
    std::uint32_t level;
    glm::dvec2 image;
  };
  struct Scratch;

  [[nodiscard]] ViewPart part_of(const Atlas& atlas, ViewSlot slot, const std::vector<SurfaceSample>& samples,
                                 std::size_t most_points) const;
  [[nodiscard]] std::optional<glm::dvec2> image_of(const Linearisation& at, ViewSlot slot,
                                                   const glm::dvec3& position) const;
  void find_places(const Linearisation& at, const ComparedPoint& point, std::uint32_t level, Scratch& scratch) const;
  [[nodiscard]] ColorSample sample_at(const SampledView& place) const;
  void point_rows(const Linearisation& at, ViewSlot slot, const ComparedPoint& point, std::size_t index,
                  Scratch& scratch, Linearised& out) const;

  std::span<const std::optional<ComparedView>> views_;
  std::vector<std::size_t> lens_of_;
  std::vector<ViewPart> parts_;
  CancelCheck cancel_check_;
};

}  // namespace lumatlas
