// SPDX-License-Identifier: GPL-3.0-or-later
// A capture, which every form of it is read into: photographs with poses and lenses, and depth images.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "tools/scene/geo_reference.h"
#include "tools/scene/lenses/camera_model.h"
#include "tools/scene/lenses/panorama_view.h"

namespace lumatlas {

// A photograph as a form of capture names it. Its paths may be those of another computer: find_photographs()
// (tools/scene/forms/photographs/find_photographs.h) makes them files of this one.
struct PosedPhotograph {
  std::string name;                                // relative to the folder of photographs, with '/' between folders
  std::filesystem::path file = {};                 // relative to the scene's folder
  std::optional<std::filesystem::path> mask = {};  // the same; does not leave it
  CameraModel lens = {};                           // passes check()
  glm::dquat cam_from_world_rotation{1, 0, 0, 0};  // unit; of lumatlas's camera, mesh/camera/camera.h
  glm::dvec3 cam_from_world_translation{0.0};      // each within 1e12
  bool black_rim = false;                          // another program's undistortion may have left one
  std::uint32_t id = 0;                            // COLMAP's image number, which its points name
  std::optional<PanoramaFace> panorama = {};       // the file is a panorama, of which this is a view by the lens
  bool held_out = false;                           // its form names it among those that are for scoring
  std::string bad = {};  // why it cannot be used; lens and pose then mean nothing. See BadPhotographs
  std::string named_by = {},
              sized_by = {};  // the file that names it, and the one that has its size; empty: the form's file
};

// Says how a reader treats a photograph whose record cannot be used, such as one with a focal length of NaN.
enum class BadPhotographs {
  refuse,  // throw InputError
  keep,    // sets PosedPhotograph::bad
};

// A picture of depths, z in the camera frame, beside the photographs.
struct PosedDepth {
  std::filesystem::path file;  // relative to the scene's folder, which it does not leave; 16-bit, 0: not measured
  double unit = 0;             // world units that a stored 1 is, finite, > 0
  // The lens of a picture of this shape, whose size may be another than the file's; passes check().
  CameraModel lens = {};
  glm::dquat cam_from_world_rotation{1, 0, 0, 0};  // as for a photograph
  glm::dvec3 cam_from_world_translation{0.0};
  // A picture of the same size, relative to the scene's folder: where it is 0, the depth is not to be trusted.
  std::optional<std::filesystem::path> confidence = {};
};

struct Capture {
  std::string form = {};  // such as "COLMAP", and the file that it was told by: see read_capture()
  std::filesystem::path file = {};
  std::vector<PosedPhotograph> photographs = {};  // sorted by name, in byte order; at least one, no name twice
  std::vector<PosedDepth> depths = {};
  std::optional<std::filesystem::path> points = {};  // a PLY, relative to the scene's folder
  std::vector<std::string> notes = {};               // sentences: what was assumed, what was left out
  std::size_t left_out = 0;                          // photographs that the notes say are left out
  std::optional<GeoReference> georeference = {};     // none: the form says nothing of it
};

// The directions of a form's camera axes.
enum class CameraAxes {
  right_down_forward,  // OpenCV, COLMAP, lumatlas
  right_up_backward,   // OpenGL, ARKit
};

// Sets the pose from the axes of the form's camera, in world coordinates, and where it stands. Returns the rule that
// is broken, empty if none is: axes of length 1 and at right angles within a hundredth, which are not mirrored; a
// centre within 1e12.
[[nodiscard]] std::string set_pose(PosedPhotograph& photograph, const glm::dmat3& world_from_camera,
                                   const glm::dvec3& center, CameraAxes axes);

// Throws std::invalid_argument unless `row`, the last one of a 4 x 4 of a pose, is 0 0 0 1 within 1e-6: a matrix that
// is written by columns has the camera's place there.
void check_last_row(const std::array<double, 4>& row);

// A path that stays in its folder, without "./" in it; none if it does not, or is no path to a file.
[[nodiscard]] std::optional<std::filesystem::path> inner_path(std::string_view text);

// `file` without the folder `first` if it begins with it.
[[nodiscard]] std::string name_without(const std::filesystem::path& file, std::string_view first);

// The folder of a capture, and how to read it.
struct CaptureRequest {
  std::filesystem::path scene;                       // the folder
  std::optional<std::filesystem::path> images = {};  // the photographs' folder, if not where the form says
  BadPhotographs bad = BadPhotographs::refuse;
};

// Adds the photograph that `read` returns. Where `read` throws InputError, passes it on, or, if bad photographs are
// kept, adds a photograph of that name with the sentence as PosedPhotograph::bad.
template <typename Read>
void add_photograph(Capture& capture, BadPhotographs bad, const std::string& name, const Read& read) {
  try {
    capture.photographs.push_back(read());
  } catch (const InputError& error) {
    if (bad == BadPhotographs::refuse) throw;
    capture.photographs.push_back({name, name});
    capture.photographs.back().bad = error.what();
  }
}

// Sorts the photographs by name. Throws InputError that begins with `path` if there is no photograph. Where a name
// occurs twice it throws too, or, if bad photographs are kept, keeps the first one and names the others in a note.
void finish(Capture& capture, const std::filesystem::path& path, BadPhotographs bad = BadPhotographs::refuse);

// One that was taken with the photograph, from its place and by its lens.
[[nodiscard]] PosedDepth depth_with(const PosedPhotograph& photograph, std::filesystem::path file, double unit);

// Says how many depth images there are, ASSUMED of them, and what makes a mesh of them; nothing where there are none.
void note_depths(Capture& posed, const std::string& assumed);

// "3 of 7 photographs WHY and are left out"; empty where none is.
void note_skipped(Capture& posed, std::size_t skipped, const std::string& why);

// Sets PosedPhotograph::held_out of the photographs that `paths` name, as PhotographNames::find_by_path() finds them.
// Adds a note that tells how many there are; `list` is what the note calls the list of paths.
void hold_out(Capture& capture, const std::vector<std::string>& paths, const std::string& list);

}  // namespace lumatlas
