// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/surface/written_mesh.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <numeric>

#include "atlas/images/srgb.h"
#include "atlas/vertex_split.h"
#include "mesh/used_vertices.h"
#include "mesh/visibility/visibility.h"

namespace lumatlas {

namespace {

// Places in a texture of at most 16384 texels a side are exact to an eighth of a texel.
std::uint32_t packed_place(const glm::vec2& share) {
  const auto part = [](float x) { return static_cast<std::uint32_t>(std::lround(65535 * x)); };
  return part(share.x) | part(share.y) << 16;
}

// Returns for each split vertex the value of the vertex that it copies.
template <typename T, typename Values>
std::vector<T> repeated(const Values& values, const std::vector<std::uint32_t>& source) {
  std::vector<T> split;
  split.reserve(source.size());
  for (const std::uint32_t vertex : source) split.push_back(static_cast<T>(values[vertex]));
  return split;
}

// Splits the vertices of faces that were split before by another value. `source` and `values` of the split before stay
// those of the vertices that are copied.
class Splitter {
 public:
  Splitter(std::span<const glm::uvec3> faces, std::size_t vertices) : faces_(faces.begin(), faces.end()) {
    for (std::size_t vertex = 0; vertex < vertices; ++vertex) source_.push_back(static_cast<std::uint32_t>(vertex));
  }
  // Returns the values of the vertices of all faces.
  template <typename ValueOf>
  std::vector<std::uint32_t> split(const ValueOf& value_of) {
    VertexSplit split = split_vertices(faces_, source_.size(), value_of);
    faces_ = std::move(split.faces);
    source_ = repeated<std::uint32_t>(source_, split.source);
    last_ = std::move(split.source);
    return std::move(split.values);
  }
  // Brings values of before the last split to the vertices after it.
  void follow(std::vector<std::uint32_t>& values) const { values = repeated<std::uint32_t>(values, last_); }
  [[nodiscard]] std::vector<glm::uvec3>& faces() { return faces_; }
  [[nodiscard]] const std::vector<std::uint32_t>& source() const { return source_; }  // given vertices

 private:
  std::vector<glm::uvec3> faces_;
  std::vector<std::uint32_t> source_, last_;
};

// Each vertex has the shares of the corners that it is, which are the same at all of them.
std::vector<glm::u8vec4> shares_of_vertices(const std::vector<glm::uvec3>& faces, std::size_t vertices,
                                            std::size_t first_face, const DrawZones& zones) {
  std::vector<glm::u8vec4> shares(vertices, glm::u8vec4(255, 0, 0, 0));
  for (std::size_t face = 0; face < faces.size(); ++face) {
    for (int corner = 0; corner < 3; ++corner) shares[faces[face][corner]] = zones.shares(first_face + face, corner);
  }
  return shares;
}

template <typename T>
void reorder(std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  if (!values.empty()) values = repeated<T>(values, order);
}

// The corners of the faces, those of zones of fewer cells first, for the page draws them apart.
std::vector<std::uint32_t> ordered_corners(const WrittenMesh& mesh, const DrawZones* zones) {
  std::vector<std::uint32_t> all;
  for (std::size_t cells = 1; cells <= kCellsPerZone; ++cells) {
    std::vector<std::uint32_t> corners;
    for (const glm::uvec3& face : mesh.faces) {
      const bool here = zones && !mesh.zones.empty()
                            ? zones->cells_of(static_cast<std::uint32_t>(mesh.zones[face.x])) == cells
                            : cells == 1;
      if (here) corners.insert(corners.end(), {face.x, face.y, face.z});
    }
    if (corners.empty()) continue;
    meshopt_optimizeVertexCacheStrip(corners.data(), corners.data(), corners.size(), mesh.positions.size());
    all.insert(all.end(), corners.begin(), corners.end());
  }
  return all;
}

// Renumbers the corners in the order in which they first come, and returns the vertices in it.
std::vector<std::uint32_t> by_first_corner(std::vector<std::uint32_t>& corners, std::size_t vertices) {
  UsedVertices used(vertices);
  std::vector<std::uint32_t> order;
  for (std::uint32_t& corner : corners) {
    const std::uint32_t vertex = corner;
    corner = used.number_of(vertex, [&] { order.push_back(vertex); });
  }
  return order;
}

// For each level of sRGB, of the 16-bit values that become this level again the one that ends in most zeros.
const std::array<std::uint16_t, 256>& short_linear() {
  static const std::array<std::uint16_t, 256> table = [] {
    std::array<std::uint16_t, 256> values{};
    std::array<int, 256> zeros;
    zeros.fill(-1);
    for (std::uint32_t value = 0; value <= 65535; ++value) {
      const std::uint8_t level = srgb8_from_linear(value / 65535.0);
      int ending = 0;
      while (ending < 16 && (value >> ending & 1) == 0) ++ending;
      if (ending <= zeros.at(level)) continue;
      zeros.at(level) = ending;
      values.at(level) = static_cast<std::uint16_t>(value);
    }
    return values;
  }();
  return table;
}

// A mesh of a surface, and what is known of its faces.
struct GivenMesh {
  const Mesh& mesh;
  const std::vector<CellId>& cell_of_face;
  std::uint32_t first_cell = 0;  // added to the cells of the faces
  std::size_t first_face = 0;    // number of its first face in the surface
};

WrittenMesh written_mesh(const GivenMesh& given, DrawZones* zones, const TexturePlaces* texture_places) {
  const Mesh& mesh = given.mesh;
  Splitter splitter(mesh.faces, mesh.positions.size());
  const auto cell_of = [&](std::size_t face) { return CellId(given.first_cell + given.cell_of_face[face]); };
  std::vector<std::uint32_t> cells = splitter.split([&](std::size_t face, int) { return cell_of(face); });
  const std::size_t originals = cells.size();
  std::vector<std::uint32_t> copies(originals), zone_of_vertex, places;
  std::iota(copies.begin(), copies.end(), 0u);
  const auto follow = [&] {
    splitter.follow(cells);
    splitter.follow(copies);
  };
  if (zones) {
    zone_of_vertex =
        splitter.split([&](std::size_t face, int) { return zones->of(given.first_face + face, cell_of(face)); });
    follow();
  }
  if (texture_places) {
    places = splitter.split([&](std::size_t face, int corner) {
      return packed_place((*texture_places)[face][static_cast<std::size_t>(corner)]);
    });
    follow();
    if (zones) splitter.follow(zone_of_vertex);
  }
  WrittenMesh written;
  written.positions = repeated<glm::vec3>(mesh.positions, splitter.source());
  written.cells.assign(cells.begin(), cells.end());
  written.zones.assign(zone_of_vertex.begin(), zone_of_vertex.end());
  if (zones) written.shares = shares_of_vertices(splitter.faces(), cells.size(), given.first_face, *zones);
  for (const std::uint32_t place : places) written.places.emplace_back(place & 0xffff, place >> 16);
  written.copies.assign(copies.begin() + static_cast<std::ptrdiff_t>(originals), copies.end());
  written.faces = std::move(splitter.faces());
  written.sources = splitter.source();
  return written;
}

WrittenMesh packed_mesh(WrittenMesh mesh, const DrawZones* zones, double step) {
  std::vector<std::uint32_t> corners = ordered_corners(mesh, zones);
  const std::vector<std::uint32_t> order = by_first_corner(corners, mesh.positions.size());
  reorder(mesh.positions, order);
  reorder(mesh.sources, order);
  reorder(mesh.cells, order);
  reorder(mesh.zones, order);
  reorder(mesh.shares, order);
  reorder(mesh.places, order);
  mesh.copies.clear();
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    mesh.faces[i] = {corners[3 * i], corners[3 * i + 1], corners[3 * i + 2]};
  }
  snap_to_grid(mesh.positions, step);
  return mesh;
}

}  // namespace

std::uint32_t DrawZones::of(std::size_t face, CellId cell) {
  const auto [entry, added] =
      numbers_.emplace(std::pair(shares_.zone_of_face[face], cell), static_cast<std::uint32_t>(zones_.size()));
  if (added) {
    zones_.push_back(shares_.zone_of_face[face]);
    own_cells_.push_back(cell);
  }
  return entry->second;
}

glm::u8vec4 DrawZones::shares(std::size_t face, int corner) const {
  return glm::u8vec4(glm::round(shares_.corners[face][static_cast<std::size_t>(corner)] * 255.0F));
}

std::size_t DrawZones::cells_of(std::uint32_t zone) const {
  const CellShares::Zone& cells = shares_.zones[zones_[zone]];
  return static_cast<std::size_t>(std::find(cells.begin(), cells.end(), CellId::none) - cells.begin());
}

std::vector<std::uint32_t> DrawZones::cells() const {
  std::vector<std::uint32_t> cells = own_cells_;
  for (std::size_t i = 0; i < kCellsPerZone; ++i) {
    for (const std::uint32_t zone : zones_) cells.push_back(shares_.zones[zone].at(i));
  }
  return cells;
}

void snap_to_grid(std::vector<glm::vec3>& positions, double step) {
  float longest = 0;
  for (const glm::vec3& p : positions) longest = std::max({longest, std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  constexpr int kBits = 23;
  int exponent = step > 0 ? static_cast<int>(std::floor(std::log2(step))) : -kBits;
  if (longest > 0) exponent = std::max(exponent, static_cast<int>(std::floor(std::log2(longest))) + 2 - kBits);
  exponent = std::max(exponent, -126);
  for (glm::vec3& p : positions) {
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] =
          static_cast<float>(std::ldexp(std::round(std::ldexp(static_cast<double>(p[axis]), -exponent)), exponent));
    }
  }
}

WrittenSurface written_surface(const Surface& surface, const CellShares* shares, const TexturePlaces* places,
                               std::optional<double> packed) {
  std::optional<DrawZones> all;
  if (shares) all.emplace(*shares);
  DrawZones* zones = all ? &*all : nullptr;
  WrittenSurface written;
  const Surface near = near_surface(surface);
  written.near = written_mesh({near.mesh, near.cells.cell_of_face}, zones, places);
  if (surface.far_faces > 0) {
    const FarSphere far = far_sphere_of(surface);
    written.far = written_mesh(
        {far.mesh, far.cells.cell_of_face, static_cast<std::uint32_t>(surface.near_cells()), surface.near_faces()},
        zones, nullptr);
  }
  if (zones && zones->count() > kMostZones) return written_surface(surface, nullptr, places, packed);
  if (packed) written.near = packed_mesh(std::move(written.near), zones, *packed);
  if (packed && surface.far_faces > 0) written.far = packed_mesh(std::move(written.far), zones, *packed);
  if (zones) written.zone_cells = zones->cells();
  return written;
}

// glTF wants COLOR_0 aligned to four bytes, hence alpha, and in linear light: so 16 bit, to keep what sRGB tells apart.
std::vector<glm::u16vec4> linear_colors(std::span<const glm::u8vec3> given, std::span<const std::uint32_t> sources,
                                        bool packed) {
  std::array<std::uint16_t, 256> table = short_linear();
  for (std::size_t level = 0; !packed && level < table.size(); ++level) {
    table.at(level) = static_cast<std::uint16_t>(std::lround(65535 * linear_from_srgb8()[level]));
  }
  std::vector<glm::u16vec4> colors;
  colors.reserve(sources.size());
  for (const std::uint32_t vertex : sources) {
    const glm::u8vec3& c = given[vertex];
    colors.emplace_back(table.at(c.r), table.at(c.g), table.at(c.b), 65535);
  }
  return colors;
}

}  // namespace lumatlas
