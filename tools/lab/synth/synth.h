// SPDX-License-Identifier: GPL-3.0-or-later
// Synthetic scenes with exact ground truth: solids with patterns on them, their mesh, a way through them, and
// photographs traced along the way. Lengths are about metres, z is up. Same options, same bytes.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "mesh/camera/camera.h"
#include "mesh/mesh.h"
#include "tools/lab/synth/shapes/solids.h"
#include "tools/lab/synth/shapes/surface.h"

namespace lumatlas {

// Known errors, so that what a program makes of them can be measured exactly. Each is chosen by the seed, view by view.
struct SynthDisturbances {
  // Error of the written poses: a random turn and a random shift, each causing half of the displacement in the view's
  // picture. Root mean square of the displacement in pixels, [0, an eighth of the width].
  double pose_noise = 0;
  double exposure_noise = 0;       // EV, [0, 10]: the linear light is multiplied by 2^u, u uniform in [-EV, EV]
  double white_balance_noise = 0;  // EV, [0, 10]: the same for red and for blue, green stays
  double wrong_poses = 0;          // share of the views whose written pose is plainly wrong, [0, 1]
  double passers_by = 0;           // share of the photographs with a person who is not in the mesh, [0, 1]
  double vignetting = 0;           // share of the light that is lost in the corners, [0, 1)
  // Sensor noise of the photographs: standard deviation at mid grey, 8-bit levels, [0, 64]
  double noise = 0;
  // Motion of the camera while the shutter is open: by how many pixels it moves what the view sees (root mean square),
  // [0, an eighth of the width]. The true pose is that of the middle.
  double blur = 0;
  // Errors of the mesh, made in this order; the photographs show the true surface.
  double mesh_noise = 0;  // root mean square displacement of its vertices along the normal, scene units, [0, 1]
  double holes = 0;       // share of its area that is cut out, in round patches, [0, 0.95]
  double decimate = 1;    // share of its faces that is left, [0.001, 1]

  [[nodiscard]] bool any() const;
  [[nodiscard]] bool of_mesh() const;
};

// tools/lab/synth/kinds.h has their names.
enum class SynthKind { apartment, village, wall, lab };
enum class SynthTrajectory {
  walk,     // along the scene's walk: through rooms and streets at eye level, or to and fro before a wall
  hilbert,  // along a Hilbert curve that fills the scene, as the paper's input was taken (its Fig. 7)
  orbit,    // round the scene's middle, looking at it
  random,   // places in the air and directions by chance, as the paper's test views were taken
};

struct SynthOptions {
  SynthKind kind = SynthKind::apartment;
  std::optional<SynthTrajectory> trajectory;  // none: the kind's own
  std::uint64_t seed = 1;                     // furniture, patterns, colours, and the grain of the photographs
  std::uint32_t views = 40;                   // photographs along the whole trajectory, [1, 100000]
  std::uint32_t width = 320;                  // pixels, [16, 8192]
  std::uint32_t height = 240;                 // pixels, [16, 8192]
  double fov_deg = 75;                        // horizontal field of view, (0, 170]
  std::uint32_t samples = 12;  // light paths per pixel, [1, 1024]; noise falls with the square root at worst
  // Villages along x and y, each in [1, 100]; more than one for SynthKind::village alone.
  std::array<std::uint32_t, 2> district{1, 1};
  // About how many the mesh has, [1, 20000000]; the shapes are the same, cut more or less finely.
  std::uint32_t triangles = 30000;
  SynthDisturbances disturbances;
  // Frames of a smooth path beside the walk, with their true pictures, for measuring flicker; [0, 100000]
  std::uint32_t path_frames = 0;
  double path_step = 0.02;  // between its frames, scene units along the walk; finite, > 0
  // Views from random poses with their true pictures, for scoring; [0, 100000]
  std::uint32_t test_views = 0;
  // Frames a second of a stream with depth images; 0: none is written. Finite, >= 0.
  double stream_rate = 0;
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const SynthOptions& options);

namespace synth {

// A parallelogram that shines towards cross(edge_u, edge_v), the same in all directions.
struct AreaLight {
  glm::vec3 corner{0.0F}, edge_u{1, 0, 0}, edge_v{0, 1, 0};
  glm::vec3 radiance{1.0F};
};

// The turns of a photographer who follows a way, by the share of the way that is done; radians. The defaults are chosen
// so that with 40 views of the apartment 97% of a held-out photograph is seen by another view, 79% by three.
struct Gaze {
  enum class Heading { turning, ahead, fixed } heading = Heading::turning;
  double start = 0;              // heading at the beginning, from x towards y; nothing where it is ahead
  double turns = 4;              // a turning heading's, along the way
  double swing = 0, swings = 0;  // to both sides of the heading, and how often along the way
  double level = -0.16;          // mean pitch: floors and tables matter more than ceilings
  double nod = 0.2, nods = 5;    // above and below that, and how often along the way
};

// The parallelogram that a Hilbert curve fills.
struct Flight {
  glm::dvec3 corner{0.0}, along{1, 0, 0}, aside{0, 1, 0};
  Gaze gaze;
};

struct Orbit {
  glm::dvec3 middle{0.0};  // is looked at
  glm::dvec2 radii{1.0};   // along x and y
  double height = 1;       // z of the cameras
};

// The region of cameras of random poses, restricted to the air, and how far up and down they look.
struct Stay {
  glm::dvec3 low{0.0}, high{1.0};
  double lowest_pitch = -1, highest_pitch = 0.3;  // radians
};

// All that a picture depends on, and where to take pictures from. The lights are for lighting only: what is to be seen
// of them is a surface with emission.
struct Scene {
  std::vector<Solid> solids;  // the first is a hollow Block, the air that the cameras are in
  std::vector<Material> materials;
  std::vector<AreaLight> lights;
  glm::vec3 ambient_above{0.0F}, ambient_below{0.0F};  // radiance of all that is not traced, for normals up and down
  float occlusion_reach = 0.7F;                        // how far surfaces keep ambient light away, scene units
  std::optional<Sky> sky;                              // none: what hits no surface is black
  std::vector<glm::dvec3> walk;  // control points of the closed cubic B-spline that the photographer walks
  Gaze walk_gaze;
  Flight flight;
  Orbit orbit;
  Stay stay;
  double clearance = 0.25;  // least distance of cameras in flight, in orbit and at random places, scene units
  Tessellation geometry;
};

// Makes the kind of scene with the seed and triangles that the options name. Throws std::invalid_argument for bad
// options.
[[nodiscard]] Scene make_scene(const SynthOptions& options);

// Two furnished rooms joined by a doorway. For each kind, all but the tessellation depends on the seed alone.
[[nodiscard]] Scene make_apartment(std::uint64_t seed, std::uint32_t triangles);
// Streets of gabled houses and gardens round a market place, in the open; 60 units across, mostly diffuse.
[[nodiscard]] Scene make_village(std::uint64_t seed, std::uint32_t triangles);
// The same without its tessellation, for districts.
inline constexpr double kVillageSide = 60;  // scene units
[[nodiscard]] Scene untessellated_village(std::uint64_t seed);
// Different villages side by side, whose streets and ground meet; a single one is make_village()'s. The walk goes along
// all of the streets in turn, the flight over all of it. `columns` along x and `rows` along y, >= 1.
[[nodiscard]] Scene make_district(std::uint64_t seed, std::uint32_t triangles, std::uint32_t columns,
                                  std::uint32_t rows);
// A house front in relief, 18 units wide and 11 high, that is finer than a photograph shows.
[[nodiscard]] Scene make_wall(std::uint64_t seed, std::uint32_t triangles);
// One room with benches, shelves, instruments, pipes and cables. What is written as its mesh is a scan of it
// (tools/lab/synth/scan.h).
[[nodiscard]] Scene make_lab(std::uint64_t seed, std::uint32_t triangles);

class Tracer;

// options.views cameras along the trajectory that the options name, none of them in a solid. Throws
// std::invalid_argument for bad options, a walk of fewer than four points, or where a trajectory leads through solids
// alone.
[[nodiscard]] std::vector<Camera> cameras_on_trajectory(const Scene& scene, const Tracer& tracer,
                                                        const SynthOptions& options);

// Cameras at equal steps along the walk, turning as they go, looking up and down by turns; the last is one step before
// the first. Throws std::invalid_argument for bad options or a walk of fewer than four points.
[[nodiscard]] std::vector<Camera> cameras_on_walk(const Scene& scene, const SynthOptions& options);

// options.test_views random poses that see surface in most of the picture, others than those of the trajectory. Throws
// as cameras_on_trajectory().
[[nodiscard]] std::vector<Camera> test_cameras(const Scene& scene, const Tracer& tracer, const SynthOptions& options);

// The camera of a visitor who follows the walk from its beginning, a little above the photographer and looking another
// way: options.path_frames frames at steps of options.path_step. Throws as cameras_on_walk().
[[nodiscard]] std::vector<Camera> cameras_on_path(const Scene& scene, const SynthOptions& options);

}  // namespace synth

// Makes the scene, traces its photographs and writes a COLMAP workspace into `folder`, which must exist:
// images/0000.png and so on, sparse/cameras.bin, images.bin and points3D.bin (PINHOLE; points on the surface with the
// tracks of the views that see them), mesh.ply. With disturbances also truth/: sparse/ with the true poses,
// disturbances.json, masks/0000.png and so on, white where a passer-by is, for the photographs that have one, and
// mesh.ply, the true surface, where the mesh beside the photographs is another, as it always is in the lab. With
// path_frames also path/, a workspace of the same form without mesh or points: the frames in order, without
// disturbances, of four times as many light paths, because their noise would count as change. With test_views also
// test/, a workspace like path/, of the random poses. With stream_rate also stream/, the photographs with their written
// poses and with depth images from the true ones, in the form of TUM RGB-D: see tools/lab/synth/stream.h. The files are
// the same for any number of threads. Throws std::invalid_argument for bad options, InputError where the folder cannot
// be written. `photograph_done` is called after each photograph, from any thread; what it throws ends the work.
void write_synthetic_scene(const SynthOptions& options, const std::filesystem::path& folder,
                           const std::function<void()>& photograph_done = {});

}  // namespace lumatlas
