// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/planning/plan_in_pieces.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/temporary_entry.h"
#include "mesh/face_geometry.h"
#include "mesh/readers/mesh_file.h"
#include "mesh/visibility/piecewise_looks.h"
#include "mesh/visibility/ray_visibility.h"
#include "planner/surface_distance.h"
#include "tools/base/process/interrupt.h"
#include "tools/city/city_surface.h"
#include "tools/city/planning/block_cut.h"
#include "tools/city/planning/city_cells.h"
#include "tools/city/planning/mesh_pieces.h"
#include "tools/inspection/blind_views.h"
#include "tools/inspection/mesh_diagnosis.h"
#include "tools/pipeline/refinement/lens_notes.h"
#include "tools/pipeline/surface/far_background.h"
#include "tools/pipeline/views/streaming.h"
#include "tools/scene/geo_reference.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

// Bytes that repairing a piece and cutting it into cells takes, for each face of the result.
constexpr std::uint64_t kBytesOfMakingAFace = 1200;
// Bytes of a face that rays are cast at.
constexpr std::uint64_t kBytesOfASeenFace = 200;
// Pictures of cameras take at most the plan's memory divided by this.
constexpr std::uint64_t kPictureShare = 4;

std::size_t faces_of_a_piece(const CityOptions& options) {
  if (options.piece_faces > 0) return options.piece_faces;
  return static_cast<std::size_t>(options.memory / 2 / kBytesOfMakingAFace);
}

std::size_t faces_of_the_coarse_mesh(const CityPlan& plan) {
  return static_cast<std::size_t>(plan.memory / 4 / kBytesOfASeenFace);
}

// The views of a scene and those of them that are offered.
struct OfferedCity {
  SceneViews views;
  std::vector<std::size_t> ranks;

  [[nodiscard]] std::vector<Camera> cameras() const {
    std::vector<Camera> cameras;
    for (const std::size_t rank : ranks) cameras.push_back(views.views[rank].camera);
    return cameras;
  }
};

OfferedCity read_offered(const fs::path& scene, const BuildOptions& build, const glm::dvec3& offset) {
  OfferedCity offered{read_scene_views(scene, offset, build.pictures), {}};
  offered.ranks = split(offered.views, build.hold_out).input;
  if (offered.ranks.empty()) {
    throw InputError(scene.string() + ": none of its " + std::to_string(offered.views.views.size()) +
                     " views is left to build from: check --hold and --block");
  }
  require_names_that_a_model_can_hold(stream_of(offered.views.views, offered.ranks));
  return offered;
}

// Looks at the mesh as it was given, and tells what is wrong with it, as build_model() does. Returns whether it fits.
bool judge(const fs::path& scene, const MeshPieces& pieces, const Visibility& visibility, const BuildOptions& build,
           const BuildCallback& callback, OfferedCity& offered, CityPlan& plan) {
  BuildStage stage(callback, "comparing photographs over the mesh", 0);
  std::vector<SceneView>& views = offered.views.views;
  const BlindViews blind = blind_views(views, offered.ranks, visibility);
  const MeshDiagnosis fit =
      diagnose_mesh(scene, pieces.facts(), pieces.coarse(), pieces.offset(), visibility, views, offered.ranks);
  plan.warnings.insert(plan.warnings.end(), fit.warnings.begin(), fit.warnings.end());
  if (fit.black_border > 0) leave_out_black_rims(views);
  if (!build.any_mesh) {
    if (!build.mesh_frame) require_right_frame(fit);
    require_seen(pieces.facts().mesh_file, blind, fit.likely);
  }
  const std::string warning = blind_views_warning(blind.blind, blind.looks, blind.first);
  if (!warning.empty()) plan.warnings.push_back(warning);
  stage.finish();
  return fit.likely.empty();
}

FarSphere far_of(const MeshPieces& pieces, const Visibility& visibility, const BuildOptions& build,
                 const OfferedCity& offered) {
  if (!build.completion.far_sphere || !has_demand(build.planner.coverage)) return {};
  return find_far_sphere(small_photographs(offered.views.views, offered.ranks), offered.cameras(), pieces.coarse(),
                         visibility);
}

double distance_of(const MeshPieces& pieces, const Visibility& visibility, const BuildOptions& build,
                   const OfferedCity& offered) {
  if (build.planner.coverage.ideal_distance > 0) return build.planner.coverage.ideal_distance;
  try {
    return median_surface_distance(offered.cameras(), visibility);
  } catch (const InputError& error) {
    throw InputError(pieces.facts().mesh_file.string() + ": " + error.what());
  }
}

// Returns about how many faces a mesh has once none is larger than a cell.
double faces_after_splitting(const Mesh& mesh, double cell_size) {
  constexpr double kMoreThanEquilateral = 3;  // measured: halving makes up to three times as many
  const std::vector<double> areas = face_areas(mesh);
  const double area = std::accumulate(areas.begin(), areas.end(), 0.0);
  return static_cast<double>(mesh.faces.size()) +
         kMoreThanEquilateral * area / (std::sqrt(3.0) / 4 * cell_size * cell_size);
}

// Cuts the pieces into cells, and writes them as the plan's surface.
void write_surface(const MeshPieces& pieces, const FarSphere& far, const CityOptions& options, const fs::path& folder,
                   const BuildCallback& callback, const CityPlan& plan) {
  CellOptions cells = options.build.cells;
  cells.size = plan.cell_size;
  BuildStage stage(callback, "cutting the surface into cells", pieces.count());
  std::size_t number = 0;
  for (std::size_t piece = 0; piece < pieces.count(); ++piece) {
    throw_if_interrupted();
    const Mesh mesh = pieces.read(piece);
    const double growth = faces_after_splitting(mesh, cells.size) / static_cast<double>(mesh.faces.size());
    const auto most = static_cast<std::size_t>(static_cast<double>(faces_of_a_piece(options)) / growth);
    cut_faces(mesh, std::max<std::size_t>(most, 1), [&](const std::vector<std::uint32_t>& faces) {
      MeshInput part;
      part.mesh = mesh_of_faces(mesh, faces);
      part.offset = pieces.offset();
      part.facts.mesh_file = pieces.facts().mesh_file;
      const SurfaceInput made = make_surface(std::move(part), cells);
      const bool has_far = number == 0 && !far.mesh.faces.empty();
      write_surface_piece(folder, number++, has_far ? with_far_sphere(*made.surface, far) : *made.surface,
                          chunk_faces_for(options.block_faces));
    });
    stage.tick();
  }
  stage.finish();
}

// Describes the chunks of the plan's surface, cuts them into blocks and finds what each needs.
void find_blocks(const FarSphere& far, const CityOptions& options, const fs::path& folder,
                 const BuildCallback& callback, CityPlan& plan) {
  const TemporaryEntry scratch(TemporaryEntry::Kind::folder, folder, [] { return random_temporary_name(); });
  const CitySurface surface(folder);
  std::vector<MeshPiece> pieces;
  std::vector<CellId> cell_of_face;
  std::uint32_t cells = 0;
  std::size_t first = 0;
  for (const std::size_t count : surface.chunks_of_pieces()) {
    throw_if_interrupted();
    std::vector<std::size_t> chunks(count);
    std::iota(chunks.begin(), chunks.end(), first);
    first += count;
    const ChunkedSurface piece = surface.read(chunks);
    for (const CellId cell : piece.surface.cells.cell_of_face) cell_of_face.emplace_back(cells + cell);
    cells += static_cast<std::uint32_t>(piece.surface.cells.cells.size());
    const std::vector<CityChunk> described = describe_chunks(piece);
    plan.chunks.insert(plan.chunks.end(), described.begin(), described.end());
    const fs::path file = scratch.path() / ("surface-" + std::to_string(pieces.size()) + ".ply");
    write_ply(file, piece.surface.mesh);  // which is read faster than chunks
    pieces.push_back(
        {bounds(piece.surface.mesh), piece.surface.mesh.faces.size(), [file] { return read_ply_mesh(file); }});
  }
  for (const CellId cell : far.cells.cell_of_face) cell_of_face.emplace_back(cells + cell);
  if (!far.mesh.faces.empty()) pieces.push_back({bounds(far.mesh), far.mesh.faces.size(), [far] { return far.mesh; }});
  const LookAtCity look = [&](std::span<const Camera> cameras, const auto& use) {
    look_at_pieces(pieces, cameras, plan.memory / kPictureShare, use, throw_if_interrupted);
  };
  cut_into_blocks({look, std::move(cell_of_face), {far.cells.cells.size(), far.mesh.faces.size()}}, options.block_faces,
                  callback, plan);
}

}  // namespace

bool can_plan_in_pieces(const CityOptions& options) {
  const BuildOptions& build = options.build;
  return build.refine == RefineMode::none && !build.completion.surface && build.close_holes == 0 &&
         !build.faces.faces && build.faces.pixels == 0 && build.cells.partition == Partition::clusters;
}

void plan_in_pieces(const fs::path& scene, const CityOptions& options, const fs::path& folder,
                    const BuildCallback& callback, CityPlan& plan) {
  const BuildOptions& build = options.build;
  FarSphere far;
  {
    const TemporaryEntry scratch(TemporaryEntry::Kind::folder, folder, [] { return random_temporary_name(); });
    BuildStage stage(callback, "cutting the mesh into pieces", 0);
    // The scene is judged by its coarse surface, which is in memory whole.
    const MeshPieces pieces(load_soup(scene, build.mesh, build.mesh_frame.value_or(MeshFrame{})),
                            faces_of_a_piece(options), faces_of_the_coarse_mesh(plan), scratch.path());
    stage.finish();
    plan.warnings = pieces.facts().warnings;
    {
      const std::unique_ptr<Visibility> made = make_ray_visibility(pieces.coarse());
      const Visibility& visibility = *made;
      OfferedCity offered = read_offered(scene, build, pieces.offset());
      plan.georeference = build.georeference ? build.georeference : offered.views.georeference;
      if (const auto warning = unplaced_warning(plan.georeference)) plan.warnings.push_back(*warning);
      const bool fits = judge(scene, pieces, visibility, build, callback, offered, plan);
      plan.usual_distance = distance_of(pieces, visibility, build, offered);
      plan.cell_size = build.cells.size > 0 ? build.cells.size : city_cell_size(pieces.coarse(), plan.usual_distance);
      if (!(plan.cell_size > 0)) {
        throw InputError(pieces.facts().mesh_file.string() + ": its faces have no area, so there is nothing to show");
      }
      if (fits) far = far_of(pieces, visibility, build, offered);
      for (const std::size_t rank : offered.ranks) plan.views.push_back(city_view(offered.views.views[rank]));
    }
    write_surface(pieces, far, options, folder, callback, plan);
  }
  find_blocks(far, options, folder, callback, plan);
}

}  // namespace lumatlas
