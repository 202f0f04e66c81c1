// SPDX-License-Identifier: GPL-3.0-or-later
// From a scene's mesh file to the surface that views are planned on.
#pragma once

#include <cstdint>
#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/atlas.h"
#include "mesh/camera/camera.h"
#include "mesh/cells/cells.h"
#include "mesh/repair/repair.h"
#include "tools/scene/mesh/mesh_frame.h"

namespace lumatlas {

struct SurfaceInput {
  std::shared_ptr<const Surface> surface;
  std::filesystem::path mesh_file;
  std::uint64_t file_vertices = 0;
  std::uint64_t file_faces = 0;
  bool file_has_colors = false;
  MeshFrame frame;             // how the file's coordinates became those of the poses
  double coordinate_step = 0;  // step of the file's numbers, scene units: see mesh_coordinate_step()
  RepairReport repair;
  std::uint64_t closed_holes = 0;      // see mesh/repair/holes.h
  std::uint64_t simplified_faces = 0;  // removed because no camera shows what they add
  double simplified_distance = 0;      // that the surface moved by it, scene units, estimated
  std::uint64_t split_faces = 0;       // added by splitting those that were larger than a cell
  std::vector<std::string> warnings;   // sentences about the mesh for the user
};

// Returns the offset that is subtracted from all coordinates before they become floats: the middle of the box of the
// faces whose corners are finite. If some corners are so far away that floats around the middle would be too coarse for
// the others, it is the middle of the box without the outermost hundredth of the corners on each side. It is the
// coordinates' origin if there is no such face.
[[nodiscard]] glm::dvec3 scene_origin(const TriangleSoup& soup);

// Bounds the number of faces that make_surface() keeps.
struct FaceOptions {
  std::optional<std::size_t> faces;  // about this many at most, >= 1
  // Most that the surface may move for fewer faces, in pixels of the nearest cameras, >= 0. Not used at 0, or where
  // `faces` is given.
  double pixels = 0;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const FaceOptions& options);

// The mesh of a scene, not yet divided into cells.
struct MeshInput {
  Mesh mesh;                          // repaired, less the offset
  glm::dvec3 offset{0};               // scene_origin()
  SurfaceInput facts;                 // without surface
  std::optional<std::string> strays;  // the warning of faces that cannot belong to the bulk, if there are any
};

// The triangles of a mesh file in the frame of the poses, not yet repaired.
struct SoupInput {
  TriangleSoup soup;
  SurfaceInput facts;  // of the file alone
};

// Reads the mesh and takes it to the frame of the poses by `frame`. Throws as load_mesh() does.
[[nodiscard]] SoupInput load_soup(const std::filesystem::path& scene,
                                  const std::optional<std::filesystem::path>& mesh_file, const MeshFrame& frame = {});

// Reads the mesh, takes it to the frame of the poses by `frame`, centres and repairs it, and closes holes up to
// `largest_hole` across (scene units; 0: none). Throws InputError, std::invalid_argument for a bad frame, and
// Interrupted soon after a signal.
[[nodiscard]] MeshInput load_mesh(const std::filesystem::path& scene,
                                  const std::optional<std::filesystem::path>& mesh_file, double largest_hole = 0,
                                  const MeshFrame& frame = {});

// Centres and repairs triangles that are in the frame of the poses. `name` stands for their file in messages. Throws as
// load_mesh().
[[nodiscard]] MeshInput mesh_input_of(const TriangleSoup& soup, const std::filesystem::path& name);

// Takes faces away, which depends on the cameras where `faces` says pixels, splits those larger than a cell, and makes
// cells. Throws std::invalid_argument for bad options, InputError, and Interrupted soon after a signal.
[[nodiscard]] SurfaceInput make_surface(MeshInput input, CellOptions cells, const FaceOptions& faces = {},
                                        std::span<const Camera> cameras = {});

// Makes a surface with fewer faces still, and with other cells; cells without a size keep the size before. Throws as
// make_surface() does.
[[nodiscard]] SurfaceInput with_fewer_faces(const SurfaceInput& input, CellOptions cells, const FaceOptions& faces,
                                            std::span<const Camera> cameras = {});

// Returns the warning that some faces reach so far beyond the bulk of the mesh that they cannot belong to it, if some
// do. `file` names the mesh, which lies around `offset`.
[[nodiscard]] std::optional<std::string> stray_faces_warning(const Mesh& mesh, const glm::dvec3& offset,
                                                             const std::filesystem::path& file);

// Calls load_mesh(), then make_surface() with all faces.
[[nodiscard]] SurfaceInput load_surface(const std::filesystem::path& scene,
                                        const std::optional<std::filesystem::path>& mesh_file, CellOptions options,
                                        const MeshFrame& frame = {});

}  // namespace lumatlas
