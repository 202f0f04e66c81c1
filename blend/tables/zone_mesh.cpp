// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/zone_mesh.h"

#include <algorithm>
#include <bit>
#include <glm/glm.hpp>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <utility>

#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

constexpr std::uint32_t kNone = 0xFFFFFFFF;
constexpr std::uint32_t kFirstCellBit = 28;

bool of_one_cell(const CellShares::Zone& cells) {
  return cells[1] == CellId::none;
}

// Returns the first shader in kCellsOfShader that takes that many cells.
std::size_t shader_of(const CellShares::Zone& cells) {
  const auto count = static_cast<std::size_t>(std::find(cells.begin(), cells.end(), CellId::none) - cells.begin());
  std::size_t shader = 0;
  while (kCellsOfShader.at(shader) < count) ++shader;
  return shader;
}

// The zone of each face.
std::vector<std::uint32_t> zones_of_faces(const std::vector<CellId>& cell_of_face, const CellShares& shares,
                                          ZoneCells& known) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> numbers;
  std::map<CellShares::Zone, std::uint32_t> combinations;
  std::vector<std::uint32_t> zones;
  zones.reserve(cell_of_face.size());
  for (std::size_t face = 0; face < cell_of_face.size(); ++face) {
    if (face > 0 && shares.zone_of_face[face] == shares.zone_of_face[face - 1] &&
        cell_of_face[face] == cell_of_face[face - 1]) {
      zones.push_back(zones.back());
      continue;
    }
    const auto [entry, added] = numbers.emplace(std::pair(shares.zone_of_face[face], cell_of_face[face]),
                                                static_cast<std::uint32_t>(known.cell.size()));
    if (added) {
      const CellShares::Zone& cells = shares.zones[shares.zone_of_face[face]];
      const auto [combination, is_new] =
          combinations.emplace(cells, static_cast<std::uint32_t>(known.combinations.size()));
      if (is_new) known.combinations.push_back(cells);
      known.combination.push_back(combination->second);
      known.cell.push_back(cell_of_face[face]);
    }
    zones.push_back(entry->second);
  }
  return zones;
}

// Puts two zeros before each of a number's lowest 10 bits.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | bits << 16) & 0x030000FFu;
  bits = (bits | bits << 8) & 0x0300F00Fu;
  bits = (bits | bits << 4) & 0x030C30C3u;
  return (bits | bits << 2) & 0x09249249u;
}

// Returns the faces cell by cell along a Z-order curve through the cells, so that faces near each other in this order
// are near each other in space.
std::vector<std::uint32_t> faces_in_space(const Mesh& mesh, const std::vector<CellId>& cell_of_face) {
  constexpr float kCurveSteps = 1023;
  const Bounds box = bounds(mesh);
  const glm::vec3 size = glm::max(glm::vec3(box.max - box.min), glm::vec3(std::numeric_limits<float>::min()));
  std::vector<std::uint64_t> keys;  // place on the curve of the cell's first face, cell
  std::vector<std::uint64_t> key_of_cell;
  keys.reserve(cell_of_face.size());
  for (std::size_t face = 0; face < cell_of_face.size(); ++face) {
    const std::size_t cell = cell_of_face[face];
    if (cell >= key_of_cell.size()) key_of_cell.resize(cell + 1, std::uint64_t{kNone} << 32);
    if (key_of_cell[cell] == std::uint64_t{kNone} << 32) {
      const glm::vec3 share = (mesh.positions[mesh.faces[face].x] - glm::vec3(box.min)) / size;
      const glm::uvec3 at(glm::clamp(share, glm::vec3(0), glm::vec3(1)) * kCurveSteps);
      const std::uint32_t place = spread_bits(at.x) | spread_bits(at.y) << 1 | spread_bits(at.z) << 2;
      key_of_cell[cell] = std::uint64_t{place} << 32 | cell;
    }
    keys.push_back(key_of_cell[cell]);
  }
  std::vector<std::uint32_t> order(cell_of_face.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  return order;
}

// Appends the references of a zone of several cells.
void merge_references(const CellShares::Zone& cells, const ReferenceTable& references,
                      std::vector<std::uint32_t>& merged) {
  const std::size_t first = merged.size();
  for (std::size_t i = 0; i < cells.size() && cells.at(i) != CellId::none; ++i) {
    for (const ViewSlot slot : references.of_cell(cells.at(i))) {
      const auto begin = merged.begin() + static_cast<std::ptrdiff_t>(first);
      const auto found = std::find_if(begin, merged.end(), [&](std::uint32_t entry) { return slot_of(entry) == slot; });
      if (found == merged.end()) {
        merged.push_back(slot | 1u << (kFirstCellBit + i));
      } else {
        *found |= 1u << (kFirstCellBit + i);
      }
    }
  }
}

}  // namespace

ZoneMesh zone_mesh(const Mesh& mesh, const std::vector<glm::u8vec3>& colors, const std::vector<CellId>& cell_of_face,
                   const CellShares& shares) {
  ZoneMesh copy;
  const std::vector<std::uint32_t> zones = zones_of_faces(cell_of_face, shares, copy.zone_cells);
  std::vector<std::uint32_t> newest(mesh.positions.size(), kNone);
  std::vector<std::uint32_t> older;  // the next copy of the same vertex
  const auto copied = [&](std::size_t face, int corner) {
    const std::uint32_t vertex = mesh.faces[face][corner];
    std::uint32_t found = newest[vertex];
    while (found != kNone && copy.zones[found] != zones[face]) found = older[found];
    if (found != kNone) return found;
    found = static_cast<std::uint32_t>(copy.zones.size());
    copy.zones.push_back(zones[face]);
    older.push_back(std::exchange(newest[vertex], found));
    copy.positions.push_back(mesh.positions[vertex]);
    copy.colors.push_back(colors[vertex]);
    copy.sources.push_back(vertex);
    const glm::vec4& of_cells = shares.corners[face][static_cast<std::size_t>(corner)];
    copy.shares.emplace_back(glm::round(of_cells * 65535.0F));
    return found;
  };
  const std::vector<std::uint32_t> order = faces_in_space(mesh, cell_of_face);
  for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
    const std::size_t before = copy.faces.size();
    for (const std::uint32_t face : order) {
      if (shader_of(copy.zone_cells.combinations[copy.zone_cells.combination[zones[face]]]) != shader) continue;
      copy.faces.emplace_back(copied(face, 0), copied(face, 1), copied(face, 2));
    }
    copy.face_counts.at(shader) = copy.faces.size() - before;
  }
  return copy;
}

std::uint32_t deviation_bits(float deviation) {
  return std::bit_cast<std::uint32_t>(deviation) >> 16;
}

ZoneReferences zone_references(const ZoneCells& zones, const ReferenceTable& references,
                               const std::vector<std::uint8_t>& cell_seen, const std::vector<float>& cell_deviation) {
  ZoneReferences result;
  for (const ViewSlot slot : references.views) {
    if (slot >> kFirstCellBit != 0) {
      throw GlError("the model refers to slot " + std::to_string(slot) + ", the renderer takes " +
                    std::to_string(1u << kFirstCellBit) + " slots: build it with fewer views");
    }
    result.references.push_back(slot | 1u << kFirstCellBit);
  }
  for (std::size_t cell = 0; cell < cell_seen.size(); ++cell) {
    result.cells.emplace_back(references.offsets[cell], references.offsets[cell + 1], cell_seen[cell] ? 1 : 0, 0);
  }
  result.ranges.reserve(zones.combinations.size());
  for (const CellShares::Zone& cells : zones.combinations) {
    if (of_one_cell(cells)) {
      result.ranges.emplace_back(result.cells[cells[0]]);
      continue;
    }
    const auto first = static_cast<std::uint32_t>(result.references.size());
    merge_references(cells, references, result.references);
    result.ranges.emplace_back(first, static_cast<std::uint32_t>(result.references.size()));
  }
  result.zones.reserve(zones.cell.size());
  for (std::size_t zone = 0; zone < zones.cell.size(); ++zone) {
    const std::uint32_t cell = zones.cell[zone];
    const float deviation = cell_deviation.empty() ? 0.0f : cell_deviation[cell];
    result.zones.emplace_back(result.ranges[zones.combination[zone]], cell, deviation_bits(deviation));
  }
  return result;
}

}  // namespace lumatlas
