// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/texture/placed_photographs.h"

#include <cmath>
#include <future>
#include <glm/glm.hpp>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "planner/refinement/pyramid.h"
#include "planner/refinement/surface_samples.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

using glm::dvec3;

// Shares of a face's second and third corner at a point of its plane.
glm::vec2 shares_at(const Mesh& mesh, FaceId face, const dvec3& point) {
  const glm::uvec3& f = mesh.faces[face];
  const dvec3 a(mesh.positions[f.x]), ab = dvec3(mesh.positions[f.y]) - a, ac = dvec3(mesh.positions[f.z]) - a;
  const dvec3 normal = glm::cross(ab, ac);
  const double area2 = glm::dot(normal, normal);
  if (!(area2 > 0)) return glm::vec2(0);
  return {glm::dot(glm::cross(point - a, ac), normal) / area2, glm::dot(glm::cross(ab, point - a), normal) / area2};
}

// The photographs of some numbers, in order: the next is read while the last is worked on.
class ReadAhead {
 public:
  ReadAhead(const OfferedPhotographs& offered, const std::vector<std::size_t>& numbers)
      : offered_(offered), numbers_(numbers) {
    begin();
  }
  Photograph next() {
    Photograph photograph = reading_.get();
    begin();
    return photograph;
  }

 private:
  void begin() {
    if (next_ == numbers_.size()) return;
    reading_ = std::async(std::launch::async, [this, number = numbers_[next_]] { return offered_.read(number); });
    ++next_;
  }
  const OfferedPhotographs& offered_;
  const std::vector<std::size_t>& numbers_;
  std::size_t next_ = 0;
  std::future<Photograph> reading_;  // waits for its end when it goes
};

}  // namespace

void check(const OfferedPhotographs& offered) {
  check(offered.validity);
  check(offered.refinement);
  if (!offered.list.empty() && !offered.read) {
    throw std::invalid_argument("texture: photographs are listed, but read is empty");
  }
}

PlacedPhotographs::PlacedPhotographs(const Snapshot& snapshot, const TextureViews& stored, const SurfaceColors& colors,
                                     const OfferedPhotographs& offered)
    : snapshot_(snapshot),
      colors_(colors),
      offered_(offered),
      visibility_(make_ray_visibility(snapshot.surface->mesh)) {
  // A photograph that the model holds in part is read again as a whole.
  const bool whole = snapshot.tiles.whole_views();
  std::map<std::string, std::size_t> listed;
  for (std::size_t i = 0; i < offered.list.size(); ++i) listed[offered.list[i].name] = i;
  in_model_.assign(offered.list.size(), nullptr);
  gain_in_model_.assign(offered.list.size(), dvec3(1));
  std::size_t number = 0;  // the stored view's
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (!snapshot.views[slot]) continue;
    const auto found = listed.find(snapshot.views[slot]->name);
    if (found != listed.end()) {
      in_model_[found->second] = snapshot.views[slot].get();
      gain_in_model_[found->second] = snapshot.gains[slot];
    }
    if (whole || found == listed.end()) stored_.push_back(&stored.views[number]);
    ++number;
  }
  for (std::size_t i = 0; i < offered.list.size(); ++i) {
    if (!whole || in_model_[i] == nullptr) read_.push_back(i);
  }
  places_.resize(read_.size());
}

std::size_t PlacedPhotographs::count(const Snapshot& snapshot, const OfferedPhotographs& offered) {
  std::set<std::string> names;
  for (const OfferedPhotograph& photograph : offered.list) names.insert(photograph.name);
  for (const auto& view : snapshot.views) {
    if (view) names.insert(view->name);
  }
  return names.size();
}

AlignmentTargets PlacedPhotographs::targets(const Camera& camera, const Pyramid& pyramid,
                                            const VisibilityBuffer& visible) const {
  AlignmentTargets targets;
  targets.colors.resize(pyramid.levels());
  const double focal_px = std::sqrt(camera.fx * camera.fy);
  for (const SurfaceSample& sample : choose_surface_samples(camera, pyramid, visible, offered_.refinement.samples)) {
    const glm::vec2 shares = shares_at(snapshot_.surface->mesh, sample.face, sample.position);
    const double density = focal_px / camera.cam_from_world(sample.position).z;
    const SurfaceColor finest = colors_.at(sample.face, shares.x, shares.y, density);
    if (!finest.seen) continue;
    targets.positions.push_back(sample.position);
    targets.colors[0].push_back(finest.color);
    for (std::uint32_t level = 1; level < pyramid.levels(); ++level) {
      const double coarser = density / static_cast<double>(1u << level);
      targets.colors[level].push_back(colors_.at(sample.face, shares.x, shares.y, coarser).color);
    }
  }
  return targets;
}

PlacedPhotographs::Placed PlacedPhotographs::place(std::size_t number, const Photograph& photograph) const {
  const Camera& camera = offered_.list[number].camera;
  if (const StoredView* const stored = in_model_[number]) {
    return {stored->camera, gain_in_model_[number], stored->mask->trust.all(), true};
  }
  if (!offered_.refinement.any()) return {camera, dvec3(1), {}, true};
  const Pyramid pyramid(photograph);
  const VisibilityBuffer visible = visibility_->trace(
      camera.shrunk_to(sampling_px(std::max(camera.width, camera.height), offered_.refinement.sample_px)));
  const Alignment found =
      align(camera, camera, dvec3(1), pyramid, targets(camera, pyramid, visible), offered_.refinement.alignment);
  const bool outlier = found.correlation && *found.correlation < offered_.refinement.least_correlation;
  return {found.camera, found.gain, {}, !outlier};
}

void PlacedPhotographs::each(const std::function<void(const TextureView&)>& use, const std::function<void()>& tick) {
  used_ = stored_.size();
  for (const TextureView* view : stored_) {
    throw_if_interrupted();
    use(*view);
    if (tick) tick();
  }
  std::vector<std::size_t> numbers;  // positions in read_
  std::vector<std::size_t> wanted;
  for (std::size_t i = 0; i < read_.size(); ++i) {
    if (places_[i] && !places_[i]->used) {
      if (tick) tick();
      continue;
    }
    numbers.push_back(i);
    wanted.push_back(read_[i]);
  }
  ReadAhead photographs(offered_, wanted);
  for (const std::size_t i : numbers) {
    throw_if_interrupted();
    const OfferedPhotograph& listed = offered_.list[read_[i]];
    Photograph photograph = photographs.next();
    const StoredView* const stored = in_model_[read_[i]];
    const Camera& expected = stored != nullptr ? stored->camera : listed.camera;
    if (photograph.width != expected.width || photograph.height != expected.height) {
      throw InputError(listed.name + ": is " + size_text(photograph.width, photograph.height) + " pixels, but " +
                       size_text(expected.width, expected.height) +
                       " in the model: name the scene that the model was built from");
    }
    if (!places_[i]) places_[i] = place(read_[i], photograph);
    const Placed& placed = *places_[i];
    if (placed.used) {
      const StoredView view =
          make_stored_view(listed.name, placed.camera, std::move(photograph),
                           visibility_->trace_sparsely(placed.camera), offered_.validity, placed.trust);
      use(TextureView(view, placed.gain));
      ++used_;
    }
    if (tick) tick();
  }
}

std::vector<double> densities_of(const OfferedPhotographs& offered, const Surface& surface) {
  constexpr std::uint32_t kPixels = 320;  // along the longer side; what is smaller is seen by other photographs too
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(surface.mesh);
  std::vector<double> sums(surface.cells.cells.size(), 0), counts(sums.size(), 0);
  VisibilityBuffer visible;
  for (const OfferedPhotograph& photograph : offered.list) {
    throw_if_interrupted();
    visibility->trace(photograph.camera.shrunk_to(kPixels), visible);
    const double focal_px = std::sqrt(photograph.camera.fx * photograph.camera.fy);
    for (std::size_t i = 0; i < visible.face.size(); ++i) {
      if (visible.face[i] == FaceId::none) continue;
      const CellId cell = surface.cells.cell_of_face[visible.face[i]];
      sums[cell] += std::log(focal_px / static_cast<double>(visible.depth[i]));
      ++counts[cell];
    }
  }
  for (std::size_t cell = 0; cell < sums.size(); ++cell) {
    sums[cell] = counts[cell] > 0 ? std::exp(sums[cell] / counts[cell]) : 0;
  }
  return sums;
}

}  // namespace lumatlas
