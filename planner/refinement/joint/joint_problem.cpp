// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/refinement/joint/joint_problem.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mesh/base/median.h"
#include "planner/refinement/alignment.h"
#include "planner/refinement/photometry.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kFinestPx = 1000;  // longer side: beyond, noise and compression rule the gradients
constexpr std::size_t kHeldOut = 5;        // each such point is not fitted to

// The value of a point in one view.
struct Value {
  double color;
  ViewSlot slot;
  std::uint32_t index;  // among the views that show it

  bool operator<(const Value& other) const { return color != other.color ? color < other.color : slot < other.slot; }
};

// The two values in the middle; the same one twice where there is one.
std::pair<Value, Value> middle_values(std::vector<Value>& values) {
  const auto high = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), high, values.end());
  if (values.size() % 2 == 1) return {*high, *high};
  return {*std::max_element(values.begin(), high), *high};
}

}  // namespace

// Lists that each point fills again.
struct JointProblem::Scratch {
  std::vector<SampledView> places;
  std::vector<ColorSample> seen;
  std::vector<Value> values;
};

LensCorrection correction_of(const Block& q) {
  return {std::exp(q[0]), {q[1], q[2]}, q[3], q[4], q[5], q[6]};
}

ShutterMotion motion_of(const Block& m, double depth) {
  return {{m[0], m[1], m[2]}, depth * glm::dvec3(m[3], m[4], m[5])};
}

JointProblem::JointProblem(const Atlas& atlas, std::span<const std::optional<ComparedView>> views,
                           std::span<const std::vector<SurfaceSample>> samples, std::vector<std::size_t> lens_of,
                           std::size_t most_points, CancelCheck cancel_check)
    : views_(views), lens_of_(std::move(lens_of)), parts_(views.size()), cancel_check_(std::move(cancel_check)) {
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(cancel_check_);
    parts_[slot] = part_of(atlas, ViewSlot(static_cast<std::uint32_t>(slot)), samples[slot], most_points);
  });
}

ViewPart JointProblem::part_of(const Atlas& atlas, ViewSlot slot, const std::vector<SurfaceSample>& samples,
                               std::size_t most_points) const {
  ViewPart part;
  const Camera& camera = views_[slot]->camera;
  const Pyramid& pyramid = views_[slot]->pyramid;
  while (part.level + 1 < pyramid.levels() &&
         std::max(pyramid.level(part.level).width, pyramid.level(part.level).height) > kFinestPx) {
    ++part.level;
  }
  std::vector<double> depths;
  const std::size_t stride = samples.empty() ? 1 : (samples.size() - 1) / most_points + 1;
  for (std::size_t index = 0; index < samples.size(); index += stride) {
    const SurfaceSample& sample = samples[index];
    const double z = camera.cam_from_world(sample.position).z;
    ComparedPoint point{sample.position, {}};
    for (const ViewSlot other : atlas.references(atlas.surface()->cells.cell_of_face[sample.face])) {
      if (other == slot || !views_[other]) continue;
      const std::optional<glm::dvec3> seen = seen_at(*views_[other], sample.position);
      if (!seen) continue;
      const double pixel_size = z / camera.fx;
      point.others.push_back({other, std::log2(pixel_size * views_[other]->camera.fx / seen->z)});
    }
    if (point.others.empty()) continue;
    depths.push_back(z);
    const bool held_out = depths.size() % kHeldOut == 0;
    (held_out ? part.held_out : part.points).push_back(std::move(point));
  }
  if (depths.size() < kFewestAlignmentPoints) return {};
  part.depth = upper_median(depths);
  return part;
}

namespace {

// Returns whether a point of the image plane, pixels, lies in the image or at most `margin` pixels beside it.
bool is_within(const glm::dvec2& image, const Camera& camera, double margin) {
  return image.x >= -margin && image.y >= -margin && image.x < camera.width + margin &&
         image.y < camera.height + margin;
}

}  // namespace

// Returns nothing for a point behind the camera.
std::optional<glm::dvec2> JointProblem::image_of(const Linearisation& at, ViewSlot slot,
                                                 const glm::dvec3& position) const {
  const Camera& camera = at.state.cameras[slot];
  glm::dvec3 cam = camera.cam_from_world(position);
  if (!(cam.z > 0)) return std::nullopt;
  if (at.motions[slot] != ShutterMotion{}) cam = when_read(at.motions[slot], camera, cam);
  if (!(cam.z > 0)) return std::nullopt;
  return uncorrected(at.corrections[lens_of_[slot]], camera, camera.image_from_cam(cam));
}

// The change of the distortion with the pose is left out: of second order.
ImageDerivatives JointProblem::derivatives(const JointState& state, ViewSlot slot, const glm::dvec3& position) const {
  ImageDerivatives result;
  const Camera& camera = state.cameras[slot];
  const Block& q = state.lens_parameters[lens_of_[slot]];
  glm::dvec3 cam = camera.cam_from_world(position);
  const double depth = parts_[slot].depth;
  if (cam.z > 0) cam = when_read(motion_of(state.motion[slot], depth), camera, cam);
  if (!(cam.z > 0)) {
    result.by_lens.setZero();
    result.by_own.setZero();
    return result;
  }
  const LensCorrection lens = correction_of(q);
  const glm::dvec2 image = uncorrected(lens, camera, camera.image_from_cam(cam));
  const double x = cam.x / cam.z, y = cam.y / cam.z;
  const double r2 = x * x + y * y;
  const double width = camera.width;
  const double fx = lens.focal * camera.fx, fy = lens.focal * camera.fy;
  result.by_lens << image.x - camera.cx - width * q[1], width, 0, fx * x * r2, fx * x * r2 * r2, fx * 2 * x * y,
      fx * (r2 + 2 * x * x),  //
      image.y - camera.cy - width * q[2], 0, width, fy * y * r2, fy * y * r2 * r2, fy * (r2 + 2 * y * y),
      fy * 2 * x * y;
  const double radial = 1 + r2 * (q[3] + r2 * q[4]);
  const double gx = fx * radial, gy = fy * radial;
  result.time = readout_time(camera, image);
  const double a = gx * depth / cam.z, b = gy * depth / cam.z;
  result.by_own << -gx * x * y, gx * (1 + x * x), -gx * y, a, 0, -a * x, 0,  //
      -gy * (1 + y * y), gy * x * y, gy * x, 0, b, -b * y, 0;
  return result;
}

// Finds the views that show a point where they are now. The colour of the border stands for a point that has just left
// the image, by a pixel of the level at most, so that residuals do not jump there.
void JointProblem::find_places(const Linearisation& at, const ComparedPoint& point, std::uint32_t level,
                               Scratch& scratch) const {
  scratch.places.clear();
  for (const Observation& other : point.others) {
    const Pyramid& pyramid = views_[other.slot]->pyramid;
    const double matching = std::clamp(std::round(other.level + level), 0.0, pyramid.levels() - 1.0);
    const std::optional<glm::dvec2> image = image_of(at, other.slot, point.position);
    if (!image || !is_within(*image, views_[other.slot]->camera, std::exp2(matching))) continue;
    scratch.places.push_back({other.slot, static_cast<std::uint32_t>(matching), *image});
    pyramid.prefetch(scratch.places.back().level, *image);
  }
}

// That view's colour with its gain.
ColorSample JointProblem::sample_at(const SampledView& place) const {
  const ComparedView& view = *views_[place.slot];
  ColorSample sample = view.pyramid.sample(place.level, place.image);
  sample.color *= view.gain;
  sample.d_x *= view.gain;
  sample.d_y *= view.gain;
  return sample;
}

// Rows 3 * index and the next two.
void JointProblem::point_rows(const Linearisation& at, ViewSlot slot, const ComparedPoint& point, std::size_t index,
                              Scratch& scratch, Linearised& out) const {
  const auto first = static_cast<Eigen::Index>(3 * index);
  const std::optional<glm::dvec2> image = image_of(at, slot, point.position);
  const std::uint32_t level = std::min(parts_[slot].level + at.coarser, views_[slot]->pyramid.levels() - 1);
  const bool is_seen = image && is_within(*image, at.state.cameras[slot], 0);
  if (is_seen) find_places(at, point, level, scratch);
  if (!is_seen || scratch.places.empty()) {  // there is nothing to compare
    out.r.segment<3>(first).setConstant(tukey(kTukeyCutoff).value);
    return;
  }
  out.compared[index] = true;
  const ColorSample sample = views_[slot]->pyramid.sample(level, *image);
  const ImageDerivatives own = derivatives(at.state, slot, point.position);
  out.time[index] = own.time;
  const glm::dvec3 gain = views_[slot]->gain * at.state.gain[slot];
  scratch.seen.clear();
  for (const SampledView& place : scratch.places) scratch.seen.push_back(sample_at(place));
  scratch.values.resize(scratch.seen.size());
  for (int channel = 0; channel < 3; ++channel) {
    for (std::uint32_t i = 0; i < scratch.seen.size(); ++i) {
      scratch.values[i] = {scratch.seen[i].color[channel], scratch.places[i].slot, i};
    }
    const Eigen::Index row = first + channel;
    const auto [low, high] = middle_values(scratch.values);
    const double target = 0.5 * (low.color + high.color);
    const double unit = srgb_slope(target) / at.noise;
    const double difference = unit * (gain[channel] * sample.color[channel] - target);
    const Robust r = at.robust ? tukey(difference) : Robust{difference, 1};
    const double slope = r.derivative * unit;
    const Eigen::RowVector2d gradient =
        slope * gain[channel] * Eigen::RowVector2d(sample.d_x[channel], sample.d_y[channel]);
    out.r[row] = r.value;
    out.J.row(row) = gradient * own.by_own;
    out.J(row, kPose) = slope * gain[channel] * sample.color[channel];
    out.D.row(row) = gradient * own.by_lens;
    // The median's derivative is that of the value, or the mean of the two, in the middle.
    const auto term_of = [&](const Value& value) {
      const ColorSample& seen = scratch.seen[value.index];
      return TargetTerm{value.slot, 0.5 * glm::dvec2(seen.d_x[channel], seen.d_y[channel]) * slope};
    };
    out.terms[static_cast<std::size_t>(row)] = {term_of(low), term_of(high)};
  }
}

std::vector<Linearised> JointProblem::linearise(const JointState& state, std::vector<ComparedPoint> ViewPart::*points,
                                                std::uint32_t coarser, double noise, bool robust) const {
  Linearisation at{state, {}, {}, coarser, noise, robust};
  for (const Block& q : state.lens_parameters) at.corrections.push_back(correction_of(q));
  for (std::size_t slot = 0; slot < parts_.size(); ++slot) {
    at.motions.push_back(motion_of(state.motion[slot], parts_[slot].depth));
  }
  std::vector<Linearised> all(parts_.size());
  tbb::parallel_for(std::size_t{0}, parts_.size(), [&](std::size_t slot) {
    if (!views_[slot]) return;
    check_cancelled(cancel_check_);
    const std::vector<ComparedPoint>& of_view = parts_[slot].*points;
    const auto rows = static_cast<Eigen::Index>(3 * of_view.size());
    Linearised& out = all[slot];
    out = {Eigen::VectorXd::Zero(rows),
           BlockRows::Zero(rows, kBlock),
           BlockRows::Zero(rows, kBlock),
           std::vector<std::array<TargetTerm, 2>>(static_cast<std::size_t>(rows)),
           std::vector<double>(of_view.size(), 0),
           std::vector<bool>(of_view.size(), false)};
    Scratch scratch;
    for (std::size_t index = 0; index < of_view.size(); ++index) {
      point_rows(at, ViewSlot(static_cast<std::uint32_t>(slot)), of_view[index], index, scratch, out);
    }
  });
  return all;
}

}  // namespace lumatlas
