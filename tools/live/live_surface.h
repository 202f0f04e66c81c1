// SPDX-License-Identifier: GPL-3.0-or-later
// A surface that grows with the depth frames of a stream, and follows frames whose poses turn out to be others. Or it
// is the join of pieces that the caller has meshed. Each version keeps the faces, and so the cells, of what has hardly
// changed since the one before. Erat et al. 2019, section 5, ask for it.
//
// A version is cut out, repaired and divided into cells where it has changed since the one before. What stays is copied
// and compared, which takes a time that grows with the scene: tools/live/README.md has measurements.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "atlas/surface.h"
#include "mesh/repair/growing/growing_repair.h"
#include "mesh/visibility/growing_visibility.h"
#include "mesh/visibility/visibility.h"
#include "tools/meshing/depth/growing_fusion.h"

namespace lumatlas {

class KeptDepths;
struct BendingFrame;
struct DepthGlance;

struct LiveSurfaceOptions {
  // Side of a voxel, scene units, > 0. None: kLiveVoxelPixels of the first depth frame at its median depth.
  std::optional<double> voxel;
  double cell_size = 0;  // see CellOptions::size, >= 0; 0: 1/16 of the first frame's median depth
  // Largest number of blocks of the volume, >= 1; a block has 512 voxels and takes 8 KiB. Depth frames that would need
  // more blocks are refused.
  std::size_t max_blocks = std::size_t{1} << 16U;
  // Largest number of faces, and of vertices before those at the same coordinates become one, of all pieces together,
  // >= 1. A piece beyond is refused. Pieces whose faces, split until they are no larger than a cell, would be more than
  // this by their areas make no surface; splitting may make up to four times as many as these say.
  std::size_t max_piece_faces = 5'000'000;
  glm::dvec3 offset{0};  // that was subtracted from all coordinates, see Surface::offset
  // Depth frames that may be moved are kept, a byte or two for each pixel: in memory up to the first bound, and in a
  // temporary file in `scratch_folder` up to the second, of both together; an empty name is the system's folder for
  // temporary files. Frames beyond that stay where they were fused.
  std::uint64_t kept_memory = std::uint64_t{256} << 20U;
  std::uint64_t kept_bytes = std::uint64_t{4} << 30U;
  std::filesystem::path scratch_folder;
};

// A surface of voxels as small as a depth image's pixels has far more faces than can follow a stream.
inline constexpr double kLiveVoxelPixels = 6;

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const LiveSurfaceOptions& options);

// Throws std::invalid_argument for a piece with a face that refers to no vertex, with a coordinate that is not finite
// or not below 1e10 scene units, or with colours: a live surface has none.
void check_piece(const TriangleSoup& piece);

// Wall times of the steps to a version of the surface, milliseconds.
struct GrowingTimes {
  double cutting = 0;    // out of the voxels, without small parts; or joining the pieces
  double repairing = 0;  // to a manifold mesh, and finding the faces that were there before
  double matching = 0;   // to the faces before, where repair did not follow the version before
  double cells = 0;
  double tree = 0;  // of the visibility
};

// A version of the surface, and what became of the cells of the version before: see CellGrowth.
struct GrownSurface {
  std::shared_ptr<const Surface> surface;
  std::shared_ptr<const Visibility> visibility;
  std::vector<CellId> previous_cell;
  std::vector<std::uint8_t> changed;
  GrowingTimes times;
};

class LiveSurface {
 public:
  // Throws as check() does.
  explicit LiveSurface(const LiveSurfaceOptions& options);
  ~LiveSurface();
  LiveSurface(const LiveSurface&) = delete;
  LiveSurface& operator=(const LiveSurface&) = delete;

  // Returns false, and takes nothing of the frame, if it measured nothing or there is no room for it. Depths are
  // rounded to 1/64 of a voxel, or to 1/65535 of the farthest one. Cosines and slopes are found from them, as
  // slanted_depth() does; those of the image have no effect. `name` is for move(); a frame without one is not kept.
  // Throws std::invalid_argument as GrowingFusion::add().
  bool add(const DepthImage& image, const std::string& name = {});

  // Tells the pose that a frame has in truth: that of `camera`, whose lens has no effect. A frame that was not added or
  // is not kept stays.
  void move(const std::string& name, const Camera& camera);
  // Takes the frame that is farthest from its pose out of the volume, and adds it there. Returns false if all frames
  // are within 1/50 of a voxel of theirs, by the movement of what they see. A frame that finds no room at its pose is
  // lost. Throws InputError if the file of kept frames cannot be read; the volume stays as it was then.
  bool follow_move();
  [[nodiscard]] std::size_t moved() const { return moved_.size(); }  // frames that may have to follow
  // Returns whether a frame is still so far from its pose that its surface would be there twice: by a voxel.
  [[nodiscard]] bool has_doubles() const;
  // Returns the last version, bent as the frames have moved since it was made or bent, with the faces and cells that it
  // had: it serves until the frames have followed and a version can be made of them. Of many frames 300 that have moved
  // and 100 others decide. Vertices that would move by less than 1/50 of a voxel stay. None if no frame has moved by a
  // quarter of a voxel, a vertex or camera would be 1e10 scene units away or farther, there is no version, or it is one
  // of pieces. A version that follows has other cells where it bent.
  [[nodiscard]] std::optional<GrownSurface> bend();

  // Brings a piece, replaces the one of the same id, or removes it if the new one has no faces. The soup must be as
  // check_piece() wants it. The caller gives either pieces or depth frames (std::logic_error).
  void replace_piece(std::uint32_t id, TriangleSoup piece);
  [[nodiscard]] bool has_pieces() const { return has_pieces_; }
  // Finds the usual distance of a surface of pieces: the median at which the cameras see it. Returns false if none of
  // them sees a piece. Without it, pieces make no surface. Throws InputError if the pieces cannot be looked at.
  bool find_distance(std::span<const Camera> cameras);
  // Takes half the diagonal of the pieces for the usual distance, where no camera ever saw them.
  void guess_distance();

  // Returns the next version; none as long as frames or pieces make no surface. Throws InputError if pieces cannot be
  // made a surface: because they have no area, or are so large for the usual distance that they would become too many
  // cells. The version before stays the one that the next is compared with.
  [[nodiscard]] std::optional<GrownSurface> grow(GrowingFusion::Show show = GrowingFusion::Show::what_changed);
  // Returns the median depth of the first frame, or what was found for pieces, scene units; 0 before it.
  [[nodiscard]] double usual_distance() const { return usual_distance_; }

 private:
  // A frame that is in the volume.
  struct Frame {
    Camera fused, wanted;  // the camera that it was fused with, and the pose that it is to have
    Camera shown;          // that the last version has it with
    std::size_t kept = 0;  // its number in `kept_`
    std::shared_ptr<const DepthGlance> glance;
  };

  void start(const DepthImage& image);
  void set_distance(double distance);
  [[nodiscard]] TriangleSoup joined_pieces() const;
  [[nodiscard]] GrownSoup grown_pieces();
  [[nodiscard]] std::optional<GrownMesh> fused_mesh(GrowingFusion::Show show, bool follows, GrowingTimes& times);
  [[nodiscard]] GrownMesh joined_mesh(bool follows, GrowingTimes& times);
  void refuse_too_large(const Mesh& mesh) const;
  [[nodiscard]] double movement(const Camera& from, const Camera& to) const;
  [[nodiscard]] bool bends(const Frame& frame) const;
  [[nodiscard]] std::vector<BendingFrame> bending_frames() const;

  LiveSurfaceOptions options_;
  std::unique_ptr<GrowingFusion> fusion_;  // null before the first frame
  std::unique_ptr<GrowingVisibility> visibility_;
  double usual_distance_ = 0;
  std::shared_ptr<const Surface> last_;
  double voxel_ = 0;  // scene units; 0 before the first frame
  std::unique_ptr<KeptDepths> kept_;
  std::unordered_map<std::string, Frame> frames_;
  std::set<std::string> moved_;  // frames whose pose may be another one than they were fused with
  bool has_pieces_ = false;      // pieces were given
  struct Piece {
    TriangleSoup soup;
    std::optional<TriangleSoup> before;         // that it has replaced since the last version
    std::optional<std::uint32_t> first_vertex;  // of the piece in the last version
    std::uint32_t first_face = 0;               // there
  };
  std::map<std::uint32_t, Piece> pieces_;
  GrowingRepair repair_;
  bool repair_follows_ = false;   // the soup that it repaired last is that of the last version
  bool last_has_splits_ = false;  // faces of the last version were split
};

}  // namespace lumatlas
