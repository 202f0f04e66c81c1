// SPDX-License-Identifier: GPL-3.0-or-later
// A scene's mesh with what photographs show past it: the surface that it lacks, and the far sphere.
#pragma once

#include <cstddef>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "atlas/surface.h"
#include "mesh/visibility/visibility.h"
#include "tools/budget/build_progress.h"
#include "tools/meshing/contradicted_faces.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

struct CompletionOptions {
  // Add surface that photographs agree on and the mesh lacks, and remove faces that they contradict: some 2 s a
  // photograph and core.
  bool surface = false;
  bool far_sphere = true;  // add what they agree to be far
  // Folder for the files of the stereo, 1.4 MB a photograph. The next build with the same folder goes on from them, and
  // remove_stereo_work() removes them. Empty: a temporary folder.
  std::filesystem::path stereo_folder;
};

// Shares of the photographs' valid pixels, [0, 1], by what they see; the rest is filled from its surroundings.
struct FrameShares {
  double surface = 0;  // the mesh as it was given
  double added = 0;    // surface that was added to it
  double far = 0;      // the far sphere
};

// Returns the warning that much of the photographs is filled from its surroundings; empty where it is not.
[[nodiscard]] std::string filled_frames_warning(const FrameShares& shares);

// Returns the folder beside a model, OUTPUT.stereo, in which an interrupted build of it leaves its stereo.
[[nodiscard]] std::filesystem::path stereo_folder_of(const std::filesystem::path& output);

struct CompletedSurface {
  FarSphere far;
  FrameShares shares;
  std::size_t added_faces = 0;
  std::size_t faces_before = 0;  // those of the added faces that stand before the mesh (tools/meshing/faces_before.h)
  std::size_t matched = 0;       // photographs that depths were taken from; 0: added surface can bring too little
  // Faces of the mesh that photographs contradict (tools/meshing/contradicted_faces.h) and that were removed.
  ContradictedFaces contradicted;
  std::optional<double> gain_db;  // completion_gain_db() of what photographs show; none: nothing, or it is not known
  std::vector<std::string> warnings;  // sentences: why the mesh was not changed as photographs say
};

// The changes that complete_surface() would make to a mesh.
struct CompletionPlan {
  FrameShares shares;        // none added
  std::size_t to_match = 0;  // photographs that would be matched; 0: added surface can bring too little
  std::size_t through = 0;   // how many of these photographs look through the mesh (points_through_mesh.h)
  // Gain of PSNR over whole frames that added surface can bring at most (completion_gain.h), dB. None: the mesh lacks
  // too little to look, or photographs cannot be compared.
  std::optional<double> largest_gain_db;
};

// Plans the completion without matching photographs. Looks at the views of `ranks`, in the frame of the mesh, from
// which `offset` was subtracted. Throws Interrupted soon after a signal.
[[nodiscard]] CompletionPlan plan_completion(const SceneViews& views, const std::vector<std::size_t>& ranks,
                                             const Mesh& mesh, const glm::dvec3& offset);

// Returns what `lumatlas inspect` prints of the frames of a scene's good views, in the frame of the mesh: {"surface",
// "far", "lacking", "largest_gain_db" (null: none), "to_match", "through"}.
[[nodiscard]] nlohmann::json frames_json(const SceneViews& views, const Mesh& mesh, const glm::dvec3& offset);

// Adds surface to `mesh` and finds its far sphere. `views` are those of `scene`, in the frame of the mesh; the views of
// `ranks` are looked at. Surface is added if more than a hundredth of their valid pixels see neither the mesh nor the
// far sphere, if an exact surface there would bring 0.6 dB or more over whole frames (completion_gain.h), and if the
// surface that is found makes pictures better. The photographs that see least are matched, 100 at most, and those that
// look through the mesh (points_through_mesh.h). Faces that the matched photographs contradict are removed, unless they
// are more than kMostContradicted of the mesh, and faces that they show before the mesh are added. Then the mesh is
// continued by guesses (extended_surface.h) if more than 0.5 % still see nothing, unless it is known that less than
// 0.6 dB could be gained. Throws Interrupted soon after a signal, and BuildStopped.
[[nodiscard]] CompletedSurface complete_surface(const std::filesystem::path& scene, const SceneViews& views,
                                                const std::vector<std::size_t>& ranks, const CompletionOptions& options,
                                                const BuildCallback& callback, MeshInput& mesh);

}  // namespace lumatlas
