// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/tables/zone_mesh.h"

#include <algorithm>
#include <bit>
#include <glm/glm.hpp>
#include <string>
#include <unordered_map>
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

// Numbers the zones of the faces of some cells, and those of each face.
class ZoneNumbers {
 public:
  ZoneNumbers(const CellShares& shares, ZoneCells& zones) : shares_(shares), zones_(zones) {}

  void begin_cell(CellId cell) {
    cell_ = cell;
    of_cell_.clear();
  }
  // Returns the zone of a face of the cell.
  std::uint32_t of(std::uint32_t face) {
    const std::uint32_t shared = shares_.zone_of_face[face];
    if (!of_cell_.empty() && of_cell_.back().first == shared) return of_cell_.back().second;
    const auto known =
        std::find_if(of_cell_.begin(), of_cell_.end(), [&](const auto& entry) { return entry.first == shared; });
    if (known != of_cell_.end()) {
      std::swap(*known, of_cell_.back());
      return of_cell_.back().second;
    }
    const auto [combination, is_new] =
        combinations_.emplace(shared, static_cast<std::uint32_t>(zones_.combinations.size()));
    if (is_new) zones_.combinations.push_back(shares_.zones[shared]);
    of_cell_.emplace_back(shared, static_cast<std::uint32_t>(zones_.cell.size()));
    zones_.combination.push_back(combination->second);
    zones_.cell.push_back(cell_);
    return of_cell_.back().second;
  }

 private:
  const CellShares& shares_;
  ZoneCells& zones_;
  CellId cell_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> of_cell_;   // zone of the shares, number; the last one met last
  std::unordered_map<std::uint32_t, std::uint32_t> combinations_;  // by zone of the shares
};

// Finds the copy of a vertex that has a zone.
class CopyTable {
 public:
  explicit CopyTable(std::size_t corners) : entries_(std::bit_ceil(corners + 1), {kNone, kNone, kNone}) {}

  // Returns the copy, and whether it is new: it has the number `next` then.
  std::pair<std::uint32_t, bool> find(std::uint32_t vertex, std::uint32_t zone, std::uint32_t next) {
    const std::uint64_t key = (std::uint64_t{zone} << 32U | vertex) * 0x9e3779b97f4a7c15ull;
    for (std::size_t i = key >> 32U;; ++i) {
      Entry& entry = entries_[i & (entries_.size() - 1)];
      if (entry.copy == kNone) {
        entry = {vertex, zone, next};
        return {next, true};
      }
      if (entry.vertex == vertex && entry.zone == zone) return {entry.copy, false};
    }
  }

 private:
  struct Entry {
    std::uint32_t vertex, zone, copy;
  };
  std::vector<Entry> entries_;
};

// Lists the references of zones of several cells, one zone after another.
class MergedReferences {
 public:
  // Both must outlive this. `merged`: the list that is appended to.
  MergedReferences(const ReferenceTable& references, std::vector<std::uint32_t>& merged)
      : references_(references), merged_(merged) {
    std::uint32_t slots = 0;
    for (const ViewSlot slot : references.views) slots = std::max(slots, slot + 1);
    place_of_slot_.resize(slots);
  }

  void append(const CellShares::Zone& cells) {
    const std::size_t first = merged_.size();
    for (std::size_t i = 0; i < cells.size() && cells.at(i) != CellId::none; ++i) {
      for (const ViewSlot slot : references_.of_cell(cells.at(i))) {
        std::size_t& place = place_of_slot_[slot];
        if (place < first || place >= merged_.size() || slot_of(merged_[place]) != slot) {  // it is of another zone
          place = merged_.size();
          merged_.push_back(slot);
        }
        merged_[place] |= 1u << (kFirstCellBit + i);
      }
    }
  }

 private:
  const ReferenceTable& references_;
  std::vector<std::uint32_t>& merged_;
  std::vector<std::size_t> place_of_slot_;  // in `merged_`, where it was listed last; any, where it was not
};

}  // namespace

ChunkMesh chunk_mesh(const Mesh& mesh, const FacesOfCells& faces, std::span<const CellId> cells,
                     const CellShares& shares) {
  struct CornersOfFace {
    std::uint32_t face, zone, cell, first_corner;
  };
  ChunkMesh chunk;
  std::array<std::vector<CornersOfFace>, kCellsOfShader.size()> of_shader;
  ZoneNumbers zones(shares, chunk.zone_cells);
  std::size_t all = 0;
  for (std::uint32_t cell = 0; cell < cells.size(); ++cell) {
    zones.begin_cell(cells[cell]);
    const std::span<const std::uint32_t> of_cell = faces.of(cells[cell]);
    all += of_cell.size();
    for (std::uint32_t i = 0; i < of_cell.size(); ++i) {
      const std::uint32_t zone = zones.of(of_cell[i]);
      of_shader.at(shader_of(shares.zones[shares.zone_of_face[of_cell[i]]])).push_back({of_cell[i], zone, cell, 3 * i});
    }
  }
  CopyTable copies(3 * all);
  for (std::size_t shader = 0; shader < of_shader.size(); ++shader) {
    chunk.faces.at(shader).reserve(of_shader.at(shader).size());
    for (const auto& [face, zone, cell, first_corner] : of_shader.at(shader)) {
      glm::uvec3 corners;
      for (int corner = 0; corner < 3; ++corner) {
        const std::uint32_t vertex = mesh.faces[face][corner];
        const auto [copy, is_new] = copies.find(vertex, zone, static_cast<std::uint32_t>(chunk.zones.size()));
        corners[corner] = copy;
        if (!is_new) continue;
        chunk.zones.push_back(zone);
        chunk.positions.push_back(mesh.positions[vertex]);
        chunk.sources.push_back({cell, first_corner + static_cast<std::uint32_t>(corner)});
        const glm::vec4& of_cells = shares.corners[face][static_cast<std::size_t>(corner)];
        chunk.shares.emplace_back(glm::round(of_cells * 65535.0F));
      }
      chunk.faces.at(shader).push_back(corners);
    }
  }
  return chunk;
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
  std::vector<bool> is_taken(cell_seen.size(), false);
  MergedReferences merged(references, result.references);
  for (const CellShares::Zone& cells : zones.combinations) {
    // Several chunks have the same combination if its cell stands for others. Each ranks a list of its own.
    if (of_one_cell(cells) && !is_taken[cells[0]]) {
      is_taken[cells[0]] = true;
      result.ranges.emplace_back(result.cells[cells[0]]);
      continue;
    }
    const auto first = static_cast<std::uint32_t>(result.references.size());
    merged.append(cells);
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
