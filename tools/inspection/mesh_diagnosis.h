// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the likely fault where the mesh of a scene and its photographs do not fit: tries simple explanations and names
// the one under which they do.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "mesh/mesh.h"
#include "mesh/visibility/visibility.h"
#include "tools/inspection/mesh_fit.h"
#include "tools/scene/mesh/mesh_frame.h"
#include "tools/scene/scene.h"
#include "tools/surface/surface_input.h"

namespace lumatlas {

// The defaults were chosen on five real scenes and 16 synthetic ones. Correlations of scenes that fit are 0.27 to 0.38,
// by which photographs are looked at (a scan whose poses are some centimetres off), and 0.53 to 0.72; of those that do
// not, -0.02 to 0.17, as under every wrong explanation. A coarse mesh of few points that fits may have 0.13: there the
// points speak for it.
struct MeshDiagnosisOptions {
  MeshFitOptions fit;
  double least_correlation = 0.25;  // below it, mesh and photographs are under suspicion, (0, 1)
  double chance = 0.2;              // up to it they are told not to fit even if nothing explains it, (0, 1)
  double plainly_better = 0.15;     // than the correlation as given: that of an explanation that is named, (0, 1)
  // With how many others each photograph must share points of the mesh, on average, under an explanation that is named:
  // a mesh that is made small enough is in few pictures, and these may agree by chance. >= 1
  double least_shared = 2;
  // The share of the scene's points that must lie on the mesh, within a tolerance relative to their depth, to clear a
  // mesh under suspicion. A mesh that was made from few of them reached 0.78; wrong meshes reached 0.00 to 0.41, which
  // is chance.
  double least_points_on_mesh = 0.6;  // (0, 1)
  double same_place = 0.05;           // (0, 1)
  double least_border = 0.003;        // share of a picture that is told of as a black border, (0, 1)
};

// Throws std::invalid_argument naming the field, its value and the rule that it breaks.
void check(const MeshDiagnosisOptions& options);

struct MeshDiagnosis {
  MeshFit as_given;
  std::optional<double> points_on_mesh;      // share; only where the colours are under suspicion, and there are points
  std::optional<double> likely_correlation;  // under the explanation that is named
  double black_border = 0;                   // share of a picture's pixels
  std::string likely;                        // the explanation; empty where everything fits
  // The frame to give for the mesh file, if the explanation is one of the mesh and the colours agree plainly under it.
  std::optional<MeshFrame> remedy;
  bool wrong_frame = false;           // there is a remedy, and as given colours agree by chance and points are off it
  std::string misfit;                 // sentence: that mesh and photographs do not fit, and what is likely; or empty
  std::vector<std::string> warnings;  // sentences: `misfit` if there is one, black borders, coarse coordinates
};

// Reads some photographs, and the scene's points if colours are under suspicion; those that cannot be read do not
// matter here. `mesh` has been repaired and lies around `offset`; `facts` are those of its file.
[[nodiscard]] MeshDiagnosis diagnose_mesh(const std::filesystem::path& scene, const SurfaceInput& facts,
                                          const Mesh& mesh, const glm::dvec3& offset, const Visibility& visibility,
                                          const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                                          const MeshDiagnosisOptions& options = {});

// Throws InputError, naming the mesh's file and the remedy, for a diagnosis of a wrong frame.
void require_right_frame(const MeshDiagnosis& diagnosis);

// {"correlation", "residual", "outliers", "pairs", "points", "points_on_mesh", "black_border", "likely", "remedy"}:
// null for what was not measured; the remedy is mesh_frame_json().
[[nodiscard]] nlohmann::json mesh_diagnosis_json(const MeshDiagnosis& diagnosis);

}  // namespace lumatlas
