// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/surface_input.h"

#include <sstream>
#include <stdexcept>

#include "mesh/errors.h"
#include "mesh/mesh_file.h"
#include "tools/scene.h"

namespace lumatlas {

namespace {

// Known before large faces are split.
double cell_size(const Mesh& mesh, const CellOptions& options, const std::filesystem::path& file) {
  if (options.size > 0) return options.size;
  const double size = automatic_cell_size(mesh);
  if (!(size > 0)) throw InputError(file.string() + ": its faces have no area, so there is nothing to show");
  return size;
}

Mesh split_for_cells(const Mesh& mesh, double size, const std::filesystem::path& file) {
  try {
    return split_large_faces(mesh, size);
  } catch (const std::invalid_argument& error) {
    std::ostringstream message;
    message << file.string() << ": cannot be cut into cells of size " << size << " (" << error.what()
            << "): give a larger --cell-size";
    throw InputError(message.str());
  }
}

}  // namespace

SurfaceInput load_surface(const std::filesystem::path& scene, const std::optional<std::filesystem::path>& mesh_file,
                          CellOptions options) {
  check(options);
  SurfaceInput input;
  input.mesh_file = find_mesh(scene, mesh_file);
  const TriangleSoup soup = read_triangle_soup(input.mesh_file);
  input.file_vertices = soup.positions.size();
  input.file_faces = soup.faces.size();
  input.file_has_colors = !soup.colors.empty();
  const Bounds box = bounds(soup);
  const auto surface = std::make_shared<Surface>();
  if (!box.empty()) surface->offset = (box.min + box.max) / 2.0;
  RepairedMesh repaired;
  try {
    repaired = repair(soup, surface->offset);
  } catch (const InputError& error) {
    throw InputError(input.mesh_file.string() + ": " + error.what());
  }
  input.repair = repaired.report;
  options.size = cell_size(repaired.mesh, options, input.mesh_file);
  const std::size_t faces_before = repaired.mesh.faces.size();
  surface->mesh = split_for_cells(repaired.mesh, options.size, input.mesh_file);
  input.split_faces = surface->mesh.faces.size() - faces_before;
  surface->cells = make_cells(surface->mesh, options);
  input.surface = surface;
  return input;
}

}  // namespace lumatlas
