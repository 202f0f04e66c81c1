// SPDX-License-Identifier: GPL-3.0-or-later
// What the readers of all forms of capture but COLMAP's give, and what they have in common: poses, lenses, names.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "atlas/photograph.h"
#include "mesh/base/errors.h"
#include "tools/scene/camera_model.h"
#include "tools/scene/panorama_view.h"

namespace lumatlas {

// A photograph as a form of capture names it. Its paths may be those of another computer: find_photographs()
// (tools/scene/forms/find_photographs.h) makes them files of this one.
struct PosedPhotograph {
  std::string name;                                // relative to the folder of photographs, with '/' between folders
  std::filesystem::path file = {};                 // relative to the scene's folder
  std::optional<std::filesystem::path> mask = {};  // the same; does not leave it
  CameraModel lens = {};                           // passes check()
  glm::dquat cam_from_world_rotation{1, 0, 0, 0};  // unit; of lumatlas's camera, mesh/camera.h
  glm::dvec3 cam_from_world_translation{0.0};      // each within 1e12
  bool black_rim = false;                          // another program's undistortion may have left one
  std::uint32_t id = 0;                            // of COLMAP's image, which its points name
  std::optional<PanoramaFace> panorama = {};       // the file is a panorama, of which this is a view by the lens
  bool held_out = false;                           // its form names it among those that are for scoring
  std::string bad = {};  // why it cannot be used; lens and pose then mean nothing. See BadPhotographs
  std::string named_by = {}, sized_by = {};  // what names it, and what says its size; empty: the form's file
};

// What to do with a photograph of which a form says what cannot be, such as a focal length that is no number.
enum class BadPhotographs {
  refuse,  // throw InputError
  keep,    // as PosedPhotograph::bad
};

// A picture of depths, z in the camera frame, beside the photographs.
struct PosedDepth {
  std::filesystem::path file;  // relative to the scene's folder, which it does not leave; 16-bit, 0: not measured
  double unit = 0;             // world units that a stored 1 is, finite, > 0
  // Of a picture of this shape, whose size may be another than the file's; passes check().
  CameraModel lens = {};
  glm::dquat cam_from_world_rotation{1, 0, 0, 0};  // as of a photograph
  glm::dvec3 cam_from_world_translation{0.0};
  // A picture of the same size, relative to the scene's folder: where it is 0, the depth is not to be trusted.
  std::optional<std::filesystem::path> confidence = {};
};

struct Capture {
  std::string form = {};  // such as "COLMAP", and the file that it was told by: see read_capture()
  std::filesystem::path file = {};
  std::vector<PosedPhotograph> photographs = {};  // by name, in byte order; at least one, no name twice
  std::vector<PosedDepth> depths = {};
  std::optional<std::filesystem::path> points = {};  // a PLY, relative to the scene's folder
  std::vector<std::string> notes = {};               // sentences: what was assumed, what was left out
  std::size_t left_out = 0;                          // photographs that the notes say are left out
};

// Where the axes of a form's camera point.
enum class CameraAxes {
  right_down_forward,  // OpenCV, COLMAP, lumatlas
  right_up_backward,   // OpenGL, ARKit
};

// Sets the pose from the axes of the form's camera, in world coordinates, and where it stands. Returns the rule that
// is broken, empty if none is: axes of length 1 and at right angles within a hundredth, which are not mirrored; a
// centre within 1e12.
[[nodiscard]] std::string set_pose(PosedPhotograph& photograph, const glm::dmat3& world_from_camera,
                                   const glm::dvec3& center, CameraAxes axes);

// A lens by Brown's coefficients with OpenCV's p1 and p2. k4 stands before r^8, as k3 stands before r^6.
struct BrownLens {
  std::uint32_t width = 0, height = 0;    // pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  // pixels, (0, 0) is the corner of the picture
  double k1 = 0, k2 = 0, k3 = 0, k4 = 0;  // radial
  double p1 = 0, p2 = 0;                  // tangential
  double p3 = 0, p4 = 0;                  // the tangential terms grow with 1 + p3 r^2 + p4 r^4
  double skew = 0;                        // pixels that x grows by for each unit of y in the plane z = 1
  bool fisheye = false;                   // the coefficients are of the angle to the axis instead of its tangent
};
// The simplest model that has all of the coefficients. Throws std::invalid_argument as check() does.
[[nodiscard]] CameraModel lens_of(const BrownLens& brown);

// Throws std::invalid_argument unless `row`, the last one of a 4 x 4 of a pose, is 0 0 0 1 within 1e-6: a matrix that
// is written by columns has the camera's place there.
void check_last_row(const std::array<double, 4>& row);

// A path that stays in its folder, without "./" in it; none if it does not, or is no path to a file.
[[nodiscard]] std::optional<std::filesystem::path> inner_path(std::string_view text);

// `file` without the folder `first` if it begins with it.
[[nodiscard]] std::string name_without(const std::filesystem::path& file, std::string_view first);

// What a form is asked for.
struct CaptureRequest {
  std::filesystem::path scene;                       // the folder
  std::optional<std::filesystem::path> images = {};  // where the photographs are, if not where the form says
  BadPhotographs bad = BadPhotographs::refuse;
};

// Adds the photograph that `read` returns. What it throws of InputError is the caller's, or, where bad ones are kept,
// what is bad about the photograph `name`.
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

// Sorts by name. Throws InputError that begins with `path` if there is no photograph, and, unless bad ones are kept, if
// a name occurs twice; else the first of these is kept, and a note names the others.
void finish(Capture& capture, const std::filesystem::path& path, BadPhotographs bad = BadPhotographs::refuse);

// One that was taken with the photograph, from its place and by its lens.
[[nodiscard]] PosedDepth depth_with(const PosedPhotograph& photograph, std::filesystem::path file, double unit);

// Says how many depth images there are, ASSUMED of them, and what makes a mesh of them; nothing where there are none.
void note_depths(Capture& posed, const std::string& assumed);

// "3 of 7 photographs WHY and are left out"; empty where none is.
void note_skipped(Capture& posed, std::size_t skipped, const std::string& why);

// Holds out the photographs whose names or files end in one of `paths`, as PhotographNames::find_by_path() has it.
// `list` names these paths in a note on how many there are.
void hold_out(Capture& capture, const std::vector<std::string>& paths, const std::string& list);

// The names of photographs, to be found by what a form calls them.
class PhotographNames {
 public:
  explicit PhotographNames(std::vector<std::string> names);

  // The name that is `label`, else the only one that ends in it after a '/', else the only one that does so without its
  // ending, or without both's; where several do, the only one of the same capitals. `label` itself if there is none.
  // Throws InputError if there are several.
  [[nodiscard]] std::string find(const std::string& label) const;

  // The same for a path of any system that may lead elsewhere, as it was where the photographs were aligned: the
  // longest end of it that is a photograph. Where there is none, the path itself if it leads nowhere else, else its
  // last part.
  [[nodiscard]] std::string find_by_path(std::string_view path) const;

  // Whether a photograph has this name.
  [[nodiscard]] bool has(const std::string& name) const;

 private:
  using Index = std::unordered_multimap<std::string, std::size_t>;
  // `named`: what sentences call the label.
  [[nodiscard]] std::optional<std::string> only_one(const Index& index, const std::string& label, bool with_ending,
                                                    const std::string& named) const;

  std::vector<std::string> names_;   // in byte order
  std::vector<std::string> folded_;  // the same names, see folded()
  Index by_file_, by_stem_;          // the last part of a folded name, with and without its ending
};

// `text` with capitals made small and characters composed, as Unicode has it: two texts that look the same but for
// their capitals are then equal. Text that is not UTF-8 is returned with ASCII's capitals made small.
[[nodiscard]] std::string folded(const std::string& text);

// How parsers ask about photographs, so that they need no files themselves.
struct PhotographLookup {
  // The photograph that a form calls `label`, see PhotographNames::find_by_path(). Throws InputError for a label that
  // is several photographs.
  std::function<PosedPhotograph(std::string_view label)> find;
  // In pixels, as stored; of a photograph that cannot be looked at, the size of one beside it, so that a scene can be
  // listed whole and whoever comes to that photograph says what is wrong with it. Throws InputError if there is none.
  std::function<ImageSize(const PosedPhotograph&)> size_of;
  BadPhotographs bad = BadPhotographs::refuse;
};

// PhotographLookup::size_of. Of photographs in `images` by their names if it is given, else of their files in the
// scene's folder.
[[nodiscard]] std::function<ImageSize(const PosedPhotograph&)> sizes_in(
    const std::filesystem::path& scene, const std::optional<std::filesystem::path>& images);

// The names of all pictures in a folder and those below, with '/' between folders, in byte order. What cannot be looked
// at is left out: whoever opens it says why.
[[nodiscard]] std::vector<std::string> pictures_in(const std::filesystem::path& folder);

// For telling a form: the files of a folder, not of those below, whose names end in `ending` in any case, by name; and
// the first 4096 bytes of one. Both are empty where nothing can be looked at.
[[nodiscard]] std::vector<std::filesystem::path> files_ending_in(const std::filesystem::path& folder,
                                                                 std::string_view ending);
[[nodiscard]] std::string first_bytes(const std::filesystem::path& file);

// In the folder of photographs if one is given, else in the scene's folder images/ or, without one, in the scene's
// folder.
[[nodiscard]] PhotographLookup photographs_of(const CaptureRequest& request);

}  // namespace lumatlas
