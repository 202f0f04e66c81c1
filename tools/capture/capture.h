// SPDX-License-Identifier: GPL-3.0-or-later
// The whole way from photographs and videos to a saved model, in steps that are not done twice.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "atlas/images/photograph.h"
#include "tools/capture/colmap/colmap_program.h"
#include "tools/capture/sources/prepared_photographs.h"
#include "tools/meshing/scene_mesh.h"
#include "tools/pipeline/build_model.h"

namespace lumatlas {

struct CaptureOptions {
  std::size_t most_frames = 300;  // that become photographs, of all videos together, >= 2
  ColmapOptions colmap;
  // A scene of any form with poses of these photographs, which COLMAP then does not look for.
  std::optional<std::filesystem::path> poses;
  std::optional<std::filesystem::path> masks;  // folder: NAME.png or NAME.jpg.png, black where NAME.jpg is not used
  // Pictures, work and what is held out are the capture's own; `points`: in COLMAP's coordinates.
  SceneMeshOptions mesh;
  BuildOptions build;  // mesh and pictures too
  ImageCoding photographs;
};

// Throws std::invalid_argument naming the field, its value and the rule.
void check(const CaptureOptions& options);

// Returns the folder for poses, mesh and logs where none is named: "office-capture" beside "office", "office/" and
// "office.glb".
[[nodiscard]] std::filesystem::path capture_beside(std::filesystem::path model);

// Callbacks by which the caller follows the work. Any may be empty.
struct CaptureListener {
  std::function<void(const std::string& sentence)>
      say;              // called when a step begins, for one that was done before, and with advice
  StageProgress stage;  // progress of all steps but the build
  BuildCallback build;
};

struct CaptureStep {
  std::string name;  // "photographs" (where some had to be made), "features", "matching", "mapping", "mesh" or "build"
  bool done_before;  // an earlier run did it with the same inputs
  double time_ms;    // wall time now
};

struct CaptureResult {
  std::size_t photographs = 0;                  // in the folder, and made of what lies there
  std::size_t converted = 0;                    // how many of these were converted from other forms
  std::vector<CapturedVideo> videos;            // videos with frames that became photographs
  std::map<std::string, std::string> left_out;  // files that are not used, by name, with the reason
  std::vector<std::string> missed;              // photographs without a place, by name
  // Number of photographs of each reconstruction, the largest first, which is used; they are not connected.
  std::vector<std::size_t> reconstructions;
  std::vector<CaptureStep> steps;
  std::vector<std::string> outliers;  // names of placed photographs that the build left out: they agree with no other
  std::vector<std::string> warnings;  // reasons not to trust the mesh, in sentences; none where it was made before
  nlohmann::json summary;             // the build's: tools/pipeline/output/build_summary.h
};

// Makes a model of a folder of photographs and videos, or of one video: photographs of what COLMAP does not read, then
// features, matching and mapping by COLMAP, then mesh and build. `work` becomes a scene that every command reads:
// images/ (see prepared_photographs.h), masks (a link, with options.masks), sparse/0/, mesh.ply; beside these stand
// videos/, COLMAP's database, its other reconstructions, its logs, and capture.json, which tells what is done. A step
// is skipped if its inputs (names, sizes and times of files, options, the steps before) and outputs are as an earlier
// run left them. Features and matching that were interrupted, or that have more photographs now, continue where they
// were, and so does an interrupted mesh. Photographs that are held out give no depths to it.
//
// Throws InputError: also without COLMAP, where it fails or places no photograph, where `work` or `model` lie among the
// photographs, and where `work` holds something else; Interrupted, with what is done kept.
[[nodiscard]] CaptureResult capture(const std::filesystem::path& photographs, const std::filesystem::path& work,
                                    const std::filesystem::path& model, const CaptureOptions& options,
                                    const CaptureListener& listener);

}  // namespace lumatlas
