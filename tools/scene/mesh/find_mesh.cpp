// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <system_error>

#include "atlas/model/gltf/gltf_mesh.h"
#include "mesh/base/errors.h"
#include "mesh/base/file_ending.h"
#include "mesh/base/text_fields.h"
#include "mesh/readers/mesh_file.h"
#include "tools/base/process/child_process.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/capture_forms.h"
#include "tools/scene/forms/photographs/photograph_names.h"
#include "tools/scene/forms/unread_forms.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// From the most to the least finished. COLMAP's fused.ply is not among them: it has points but no faces.
constexpr std::array kNames{
    "mesh",                             // lumatlas and many others
    "meshed-poisson",                   // COLMAP
    "meshed-delaunay",                  // COLMAP
    "scene_dense_mesh_refine",          // OpenMVS
    "scene_dense_mesh",                 // OpenMVS
    "scene_mesh_refine",                // OpenMVS
    "scene_mesh",                       // OpenMVS
    "scene_dense_mesh_refine_texture",  // OpenMVS
    "scene_dense_mesh_texture",         // OpenMVS
    "scene_mesh_texture",               // OpenMVS
    "raw",                              // Polycam
    "odm_mesh",                         // OpenDroneMap
    "odm_25dmesh",                      // OpenDroneMap
    "texturedMesh",                     // Meshroom
};
constexpr std::array kMeshEndings{".ply", ".obj", ".stl", ".glb", ".gltf"};  // the preferred first
constexpr std::array kFolders{"", "dense", "dense/0", "odm_meshing"};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

std::string list_of_names() {
  std::string list;
  for (const char* const name : kNames) {
    list += (list.empty() ? "" : ", ") + std::string(name);
  }
  return list;
}

// Names files in the folder that may be a mesh under another name: "; there is office_scan.ply".
std::string others_in(const fs::path& scene) {
  constexpr std::size_t kMostNamed = 3;
  std::string list;
  std::size_t named = 0;
  for (const char* const ending : kMeshEndings) {
    for (const fs::path& file : files_ending_in(scene, ending)) {
      if (file.stem() == "fused") continue;  // COLMAP's points
      if (named == kMostNamed) return list + " and more";
      list += (named == 0 ? "; there is " : ", ") + short_reason(file.filename().string());
      ++named;
    }
  }
  return list;
}

}  // namespace

TriangleSoup read_scene_mesh(const fs::path& file) {
  const std::string ending = lower_case_ending(file);
  if (std::find(kMeshEndings.begin(), kMeshEndings.end(), ending) == kMeshEndings.end()) {
    throw InputError(file.string() + ": the ending " + in_quotes(ending) +
                     " is not .ply, .obj, .stl, .glb or .gltf; convert the mesh to one of these");
  }
  return ending == ".glb" || ending == ".gltf" ? read_gltf_mesh(file) : read_triangle_soup(file);
}

std::optional<fs::path> mesh_beside(const fs::path& scene) {
  for (const char* const folder : kFolders) {
    for (const char* const name : kNames) {
      for (const char* const ending : kMeshEndings) {
        fs::path candidate = scene / folder / (std::string(name) + ending);
        if (is_file(candidate)) {
          return candidate;
        }
      }
    }
  }
  return std::nullopt;
}

fs::path find_mesh(const fs::path& scene, const std::optional<fs::path>& given) {
  if (given) {
    if (!is_file(*given)) {
      throw InputError(given->string() + ": no such file, but it was given as the mesh");
    }
    return *given;
  }
  std::error_code ignored;
  if (!fs::is_directory(scene, ignored)) {
    throw InputError(scene.string() + ": no such folder, name a COLMAP workspace");
  }
  if (std::optional<fs::path> found = mesh_beside(scene)) return *std::move(found);
  if (forms_in(scene).empty() && !unread_form_hint(scene).empty()) throw InputError(no_poses(scene));
  throw InputError(
      scene.string() +
      ": no mesh in it, in dense/, dense/0/ or odm_meshing/ (looked for .ply, .obj, .stl, .glb and .gltf of " +
      list_of_names() + ")" + others_in(scene) + ": name one with --mesh, or make one with `" +
      shell_line("lumatlas", {"mesh", scene.string(), "-o", (scene / "mesh.ply").string()}) + "`");
}

}  // namespace lumatlas
