// SPDX-License-Identifier: GPL-3.0-or-later
// Averaged vertex colours: what is shown where no view is valid, and the baseline of view-independent colouring (what
// RGB-D fusion gives).
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "atlas/stored_view.h"
#include "atlas/surface.h"
#include "mesh/mesh.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

// The mean over views, in linear light, of the colours that they show at each vertex, weighted by validity, and by a
// thousandth of it where the vertex is at the rim of what the view sees; a view that does not see the vertex (its depth
// there is nearer by over 2%) does not count.
class VertexColorMean {
 public:
  explicit VertexColorMean(const Mesh& mesh);  // keeps a reference to it

  // `gain` as in Snapshot::gains. Throws std::invalid_argument unless the view passes check().
  void add(const StoredView& view, const glm::dvec3& gain);

  // sRGB, one per vertex. A vertex that no view showed has the mesh's own colour; where the mesh has none, the mean of
  // its neighbours' colours, spread from the nearest coloured vertices; mid-grey in a component without any.
  [[nodiscard]] std::vector<glm::u8vec3> colors() const;

 private:
  const Mesh& mesh_;
  std::vector<glm::vec4> sums_;  // weighted linear colour, weight
};

// What a view shows at a vertex.
struct VertexSample {
  std::uint32_t vertex : 31;
  std::uint32_t at_rim : 1;
  std::uint8_t r, g, b;   // sRGB, as photographed
  std::uint8_t validity;  // >= 1
};

// The same colours, to the bit, as a VertexColorMean to which all views were added by ascending slot, for a store that
// changes: a view is projected onto the vertices once, 8 bytes are kept for each that it shows, and sums are made again
// only where a view came, went or has another gain.
class VertexColors {
 public:
  // Views and gains by slot, null where there is none; the views pass check(). Sums are made anew where these differ
  // from those of the call before. Throws std::invalid_argument for a surface that is null, and unless there are as
  // many gains as views.
  [[nodiscard]] const std::vector<glm::u8vec3>& of(const std::shared_ptr<const Surface>& surface,
                                                   std::span<const std::shared_ptr<const StoredView>> views,
                                                   std::span<const glm::dvec3> gains);

 private:
  struct Shown {
    std::weak_ptr<const StoredView> view;  // which it is; a view that has left the store is not kept alive
    glm::dvec3 gain{1};
    std::vector<VertexSample> samples;  // by ascending vertex
  };

  void begin(const std::shared_ptr<const Surface>& surface);
  void follow(std::span<const std::shared_ptr<const StoredView>> views, std::span<const glm::dvec3> gains);
  void mark_blocks_of(const Shown& shown);
  void sum_marked_blocks();
  void color_marked_blocks();
  void spread();

  std::shared_ptr<const Surface> surface_;
  std::vector<Shown> shown_;          // by slot
  std::vector<std::uint8_t> marked_;  // by block of vertices: 1 if its sums must be made again
  std::vector<glm::vec4> sums_;       // by vertex: weighted linear colour, weight
  std::vector<glm::vec4> spread_;     // the same with colours that were spread, of a mesh without colours
  std::vector<glm::u8vec3> colors_;   // by vertex
  std::optional<VertexFaces> faces_;  // made when colours are spread for the first time
};

}  // namespace lumatlas
