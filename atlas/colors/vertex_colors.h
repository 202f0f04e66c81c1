// SPDX-License-Identifier: GPL-3.0-or-later
// Averaged vertex colours: shown where no view is valid, and the baseline of view-independent colouring (as RGB-D
// fusion makes it).
#pragma once

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "atlas/surface.h"
#include "atlas/views/stored_view.h"
#include "mesh/mesh.h"

namespace lumatlas {

// Sums over views at a vertex: red, green and blue in linear light times weight, and weight. Whole numbers, so that the
// sum does not depend on the order, and can be subtracted again. Light is in steps of 2^-20 and clamped to 2^10;
// validity is times 1000, or times 1 at rims. They hold 65,536 views.
using ColorSum = glm::u64vec4;

// The mean over views, in linear light, of the colours that they show at each vertex. The weight is the validity, or a
// thousandth of it if the vertex is at a rim in the view. A view that does not see the vertex (its depth there is
// nearer by over 2%) does not count.
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
  std::vector<ColorSum> sums_;
};

// The colour that a view shows at a vertex.
struct VertexSample {
  std::uint32_t vertex : 31;
  std::uint32_t at_rim : 1;
  std::uint8_t r, g, b;   // sRGB, as photographed
  std::uint8_t validity;  // >= 1
};

// The same colours, to the bit, as a VertexColorMean to which all views were added, for a store that changes: a view is
// projected onto the vertices once, and 8 bytes are kept for each that it shows. A view that comes, goes or has another
// gain is added to the sums, or subtracted from them, and no other view is looked at. Of another surface only vertices
// are projected where there was none before, or all where most are new. Every call is safe from any thread.
class VertexColors {
 public:
  using Colors = std::vector<glm::u8vec3>;  // sRGB, one per vertex

  // Returns the colours of a store at one moment, which may be earlier than that of the call before: the sums are
  // brought from there to here. Never null; the same list as before where nothing has changed. Views and gains are by
  // view slot, null where there is none; the views pass check(). Throws std::invalid_argument for a surface that is
  // null, and unless there are as many gains as views.
  [[nodiscard]] std::shared_ptr<const Colors> of(const std::shared_ptr<const Surface>& surface,
                                                 std::span<const std::shared_ptr<const StoredView>> views,
                                                 std::span<const glm::dvec3> gains);

  // Returns the number of samples that all calls together have added to sums or subtracted from them.
  [[nodiscard]] std::uint64_t samples_counted() const;

 private:
  struct Shown {
    std::weak_ptr<const StoredView> view;  // which it is; a view that has left the store is not kept alive
    glm::dvec3 gain{1};
    std::vector<VertexSample> samples;  // of places
  };

  [[nodiscard]] static bool is_of(const Shown& shown, const std::shared_ptr<const StoredView>& view);
  void begin(const std::shared_ptr<const Surface>& surface);
  [[nodiscard]] std::vector<std::uint32_t> places_in_order(const std::vector<glm::vec3>& positions) const;
  [[nodiscard]] bool take_over(const std::shared_ptr<const Surface>& surface,
                               std::span<const std::shared_ptr<const StoredView>> views);
  void update(const std::shared_ptr<const Surface>& surface, std::span<const std::shared_ptr<const StoredView>> views,
              std::span<const glm::dvec3> gains);
  void follow(std::span<const std::shared_ptr<const StoredView>> views, std::span<const glm::dvec3> gains);
  enum class Count { add, take_away };
  void count(std::span<const VertexSample> samples, const glm::dvec3& gain, Count how);
  // Returns whether no view shows the vertex.
  [[nodiscard]] bool is_bare(std::uint32_t vertex) const { return sums_[place_of_vertex_[vertex]].w == 0; }
  [[nodiscard]] std::vector<glm::vec4> spread_light() const;
  void color_changed(Colors& colors);
  void spread(Colors& colors);

  mutable std::mutex mutex_;                // guards all that follows
  std::shared_ptr<const Surface> surface_;  // null: nothing below is of use
  std::vector<Shown> shown_;                // one per view slot
  // Sums belong to places, so that a vertex that stays keeps them under another number. A place that no vertex has any
  // more is not used again, and goes when all begins anew.
  std::vector<glm::vec3> places_;
  std::vector<std::uint32_t> place_of_vertex_;
  std::vector<ColorSum> sums_;           // one per place
  std::vector<std::uint8_t> changed_;    // one per place: 1 if its sum has changed
  std::vector<glm::u8vec3> sum_colors_;  // one per place: of its sum
  bool any_changed_ = false;
  std::vector<glm::vec4> spread_;         // one per vertex: weighted linear colour and weight that have spread to it
  std::shared_ptr<const Colors> colors_;  // null: none were made of this surface
  std::uint64_t samples_counted_ = 0;
};

}  // namespace lumatlas
