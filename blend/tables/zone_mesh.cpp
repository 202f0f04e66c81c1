// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/zone_mesh.h"

#include <algorithm>
#include <bit>
#include <glm/glm.hpp>
#include <map>
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
  for (std::size_t shader = 0; shader < kCellsOfShader.size(); ++shader) {
    const std::size_t before = copy.faces.size();
    for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
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
