// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs that a model was offered, one after the other, for a texture from all of them. Photographs in the
// model are taken from it. The others are read from disk, and get exposure and pose by comparison with the model.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atlas/snapshot.h"
#include "atlas/views/validity.h"
#include "mesh/camera/camera.h"
#include "mesh/visibility/visibility.h"
#include "planner/refinement/refiner.h"
#include "tools/texture/surface_color.h"
#include "tools/texture/texture_views.h"

namespace lumatlas {

struct OfferedPhotograph {
  std::string name;  // for one that is in the model: its name there
  Camera camera;     // the pinhole view that it is undistorted to
};

struct OfferedPhotographs {
  std::vector<OfferedPhotograph> list;  // empty: there are only those in the model
  // Reads a photograph by its number in `list`. Called for one after the other, never for two at once, but from other
  // threads.
  std::function<Photograph(std::size_t)> read;
  ValidityOptions validity;
  // Refinement of photographs that are not in the model, and when one is left out as an outlier.
  RefinementOptions refinement;
};

// Throws std::invalid_argument for bad options, and for a list without read().
void check(const OfferedPhotographs& offered);

class PlacedPhotographs {
 public:
  // Keeps references to all of them.
  PlacedPhotographs(const Snapshot& snapshot, const TextureViews& stored, const SurfaceColors& colors,
                    const OfferedPhotographs& offered);

  // Calls `use` for each that is no outlier, in a fixed order: those of the model, then the others as listed. Two
  // photographs at most are in memory, of which one is being read. Where a photograph belongs is found the first time.
  // Throws what read() throws, InputError where a photograph is not of its view's size, and Interrupted.
  void each(const std::function<void(const TextureView&)>& use, const std::function<void()>& tick = {});

  // Ticks of each(): every photograph, in the model or listed.
  [[nodiscard]] static std::size_t count(const Snapshot& snapshot, const OfferedPhotographs& offered);
  [[nodiscard]] std::size_t size() const { return stored_.size() + read_.size(); }
  // After the first each(): those used, and the outliers.
  [[nodiscard]] std::size_t used() const { return used_; }
  [[nodiscard]] std::size_t outliers() const { return size() - used_; }

 private:
  struct Placed {
    Camera camera;
    glm::dvec3 gain{1.0};
    std::vector<std::uint8_t> trust;
    bool used = true;
  };
  [[nodiscard]] Placed place(std::size_t number, const Photograph& photograph) const;
  [[nodiscard]] AlignmentTargets targets(const Camera& camera, const Pyramid& pyramid,
                                         const VisibilityBuffer& visible) const;

  const Snapshot& snapshot_;
  const SurfaceColors& colors_;
  const OfferedPhotographs& offered_;
  std::unique_ptr<Visibility> visibility_;
  std::vector<const TextureView*> stored_;     // that are used as they are in the model
  std::vector<std::size_t> read_;              // numbers in the list
  std::vector<std::optional<Placed>> places_;  // in the order of read_
  std::vector<const StoredView*> in_model_;    // one per photograph of the list; null: not in the model
  std::vector<glm::dvec3> gain_in_model_;      // one per photograph of the list
  std::size_t used_ = 0;
};

// Returns for each cell the pixels per scene unit, the mean of logarithms over the photographs that see it; 0 where
// none does. Reads no photograph.
[[nodiscard]] std::vector<double> densities_of(const OfferedPhotographs& offered, const Surface& surface);

}  // namespace lumatlas
