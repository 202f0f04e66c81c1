// SPDX-License-Identifier: GPL-3.0-or-later
// Fuses depth images one after the other, as they come, and takes them out again. What an image adds is rounded to
// integers, whose sums do not depend on the order: taking an image out restores the volume to the bit.
#pragma once

#include <cstddef>
#include <memory>

#include "mesh/mesh.h"
#include "mesh/repair/growing/growing_repair.h"
#include "tools/meshing/depth/depth_fusion.h"

namespace lumatlas {

// Returns the surface of the images that came so far as often as it is asked for. An image adds to the blocks near what
// it measured alone. The free space farther before it is not cleared, as fused() does, so that the time of an image
// does not grow with the scene.
//
//   GrowingFusion fusion({.voxel = 0.02, .truncation = 0.08, .least_weight = 0.1});
//   for (const DepthImage& image : stream) {
//     if (fusion.add(image)) show(fusion.surface());
//   }
class GrowingFusion {
 public:
  // may_enlarge has no effect: voxels stay as large as they are. Throws as fused() does.
  explicit GrowingFusion(const FusionOptions& options);
  ~GrowingFusion();
  GrowingFusion(const GrowingFusion&) = delete;
  GrowingFusion& operator=(const GrowingFusion&) = delete;

  // Returns false, and takes nothing of the image, if the volume would have more than max_blocks. Throws
  // std::invalid_argument as fused() does. Time: pixels of the image, and voxels near what it measured.
  //
  // An image counts for at most 512 times least_weight in a voxel. 65,536 images that all count for as much in one
  // voxel are too many: its sum then overflows.
  bool add(const DepthImage& image);
  // Takes out an image that was added: the same numbers to the bit, or the sums are wrong from then on. Blocks that
  // nothing else has been added to go. Throws as add(). Time: that of add().
  void remove(const DepthImage& image);

  enum class Show {
    // Blocks that have been seen twice as much as when they were shown last, and blocks that an image was taken out of.
    // The others stay as they are.
    what_changed,
    everything,  // all that was added
  };
  // Returns the surface as fused() cuts it out; it does not depend on the order in which images were added. Where no
  // block near a vertex is shown anew, the vertex has the same coordinates as in the surface before, to the bit. Time:
  // voxels of the blocks that are shown anew, and a copy of all vertices and faces.
  [[nodiscard]] TriangleSoup surface(Show what = Show::what_changed);
  // Returns the same without the faces of pieces that have fewer than `fewest_faces`, as remove_small_pieces() takes
  // them away, and says which of its positions and faces the surface of the last call of either function had. Faces of
  // blocks that were cut again are not compared. If the call throws, the next one's surface is all new.
  [[nodiscard]] GrownSoup grown_surface(Show what = Show::what_changed, std::size_t fewest_faces = 0);
  [[nodiscard]] std::size_t blocks() const;  // each of 512 voxels

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
