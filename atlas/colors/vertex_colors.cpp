// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/colors/vertex_colors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include "atlas/images/pixel_memory.h"
#include "atlas/images/srgb.h"
#include "mesh/cells/spreading.h"
#include "mesh/vertex_faces.h"

namespace lumatlas {

namespace {

constexpr double kOcclusionTolerance = 0.02;  // share of the depth; above the mesh's own noise in MVS and RGB-D scans
constexpr std::uint8_t kMidGrey = 128;
// Weight of a pixel beside one at a rim, which has 1 and so decides only at vertices that no other pixels show.
constexpr std::uint64_t kInnerWeight = 1000;

constexpr double kStepsOfLight = 1 << 20;  // see ColorSum
constexpr double kMostLight = 1 << 10;

constexpr std::size_t kVertexBlock = 1024;  // vertices that one thread looks at together

// Appends what a view shows at a vertex, if it shows it at all.
void add_sample(const StoredView& view, const glm::dvec3& world, std::uint32_t vertex,
                std::vector<VertexSample>& samples) {
  const glm::dvec3 cam = view.camera.cam_from_world(world);
  if (!(cam.z > 0)) return;
  const glm::dvec2 image = view.camera.image_from_cam(cam);
  if (!(image.x >= 0 && image.y >= 0 && image.x < view.camera.width && image.y < view.camera.height)) return;
  const std::size_t pixel = static_cast<std::size_t>(image.y) * view.camera.width + static_cast<std::size_t>(image.x);
  if (cam.z > view.mask->depth[pixel] * (1 + kOcclusionTolerance) || view.mask->validity[pixel] == 0) return;
  const StoredPhotograph::Color rgb = view.photograph->color(pixel);
  samples.push_back(
      {vertex & 0x7fffffffu, view.mask->at_rim(pixel) ? 1u : 0u, rgb[0], rgb[1], rgb[2], view.mask->validity[pixel]});
}

// The vertices at `positions` from `first` on, in ascending order.
std::vector<VertexSample> samples_of(const StoredView& view, std::span<const glm::vec3> positions,
                                     std::size_t first = 0) {
  const std::size_t vertices = positions.size() - first;
  std::vector<std::vector<VertexSample>> parts((vertices + kVertexBlock - 1) / kVertexBlock);
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const std::size_t end = std::min((part + 1) * kVertexBlock, vertices);
    for (std::size_t vertex = part * kVertexBlock; vertex < end; ++vertex) {
      add_sample(view, glm::dvec3(positions[first + vertex]), static_cast<std::uint32_t>(first + vertex), parts[part]);
    }
  });
  std::size_t count = 0;
  for (const auto& part : parts) count += part.size();
  std::vector<VertexSample> samples;
  samples.reserve(count);
  for (const auto& part : parts) samples.insert(samples.end(), part.begin(), part.end());
  return samples;
}

// The samples of one view as they are summed up.
class SampleWeights {
 public:
  explicit SampleWeights(const glm::dvec3& gain) {
    const auto& linear = linear_from_srgb8();
    for (int channel = 0; channel < 3; ++channel) {
      for (std::size_t value = 0; value < linear.size(); ++value) {
        const double light = std::min(gain[channel] * static_cast<double>(linear[value]), kMostLight);
        steps_.at(static_cast<std::size_t>(channel))[value] =
            static_cast<std::uint32_t>(std::lround(light * kStepsOfLight));
      }
    }
  }

  [[nodiscard]] ColorSum operator()(const VertexSample& sample) const {
    const std::uint64_t weight = sample.validity * (sample.at_rim != 0 ? 1 : kInnerWeight);
    return weight * ColorSum(steps_[0][sample.r], steps_[1][sample.g], steps_[2][sample.b], 1);
  }

 private:
  std::array<std::array<std::uint32_t, 256>, 3> steps_{};  // for each channel and value
};

// Weighted linear colour and weight, 1 of an inner pixel that is wholly valid.
glm::vec4 light_of(const ColorSum& sum) {
  constexpr double kWhole = 255.0 * kInnerWeight;
  return {glm::dvec3(sum) / (kStepsOfLight * kWhole), static_cast<double>(sum.w) / kWhole};
}

glm::u8vec3 srgb_of(const ColorSum& sum) {
  glm::u8vec3 color;
  for (int channel = 0; channel < 3; ++channel) {
    color[channel] =
        srgb8_from_linear(static_cast<double>(sum[channel]) / (static_cast<double>(sum.w) * kStepsOfLight));
  }
  return color;
}

glm::u8vec3 srgb_of(const glm::vec4& light) {
  glm::u8vec3 color;
  for (int channel = 0; channel < 3; ++channel) {
    color[channel] = srgb8_from_linear(static_cast<double>(light[channel] / light.w));
  }
  return color;
}

std::vector<glm::vec4> light_of_all(const std::vector<ColorSum>& sums) {
  std::vector<glm::vec4> light(sums.size());
  std::transform(sums.begin(), sums.end(), light.begin(), light_of);
  return light;
}

// Finds positions by their coordinates.
class PositionTable {
 public:
  // Takes those numbered in `used`, the first of equal ones. `positions` must outlive this.
  PositionTable(const std::vector<glm::vec3>& positions, const std::vector<std::uint32_t>& used)
      : positions_(positions), entries_(std::bit_ceil(2 * used.size() + 1), kEmpty) {
    for (const std::uint32_t number : used) {
      std::size_t entry = first_entry(positions[number]);
      while (entries_[entry] != kEmpty && positions_[entries_[entry]] != positions[number]) entry = next(entry);
      if (entries_[entry] == kEmpty) entries_[entry] = number;
    }
  }

  static constexpr std::uint32_t kEmpty = std::numeric_limits<std::uint32_t>::max();
  // Returns the number of the one that is there, or kEmpty.
  [[nodiscard]] std::uint32_t find(const glm::vec3& position) const {
    std::size_t entry = first_entry(position);
    while (entries_[entry] != kEmpty && positions_[entries_[entry]] != position) entry = next(entry);
    return entries_[entry];
  }

 private:
  [[nodiscard]] std::size_t next(std::size_t entry) const { return (entry + 1) & (entries_.size() - 1); }
  [[nodiscard]] std::size_t first_entry(const glm::vec3& position) const {
    std::uint64_t hash = 0;
    for (int axis = 0; axis < 3; ++axis) {
      hash ^= std::bit_cast<std::uint32_t>(position[axis] + 0.0F);  // -0 and 0 are one position
      hash *= 0x9e3779b97f4a7c15ull;
      hash ^= hash >> 32U;
    }
    return hash & (entries_.size() - 1);
  }

  const std::vector<glm::vec3>& positions_;
  std::vector<std::uint32_t> entries_;
};

// The colour of a vertex that no view has coloured.
glm::u8vec3 own_color(const Mesh& mesh, std::size_t vertex) {
  return mesh.colors.empty() ? glm::u8vec3(kMidGrey) : mesh.colors[vertex];
}

}  // namespace

VertexColorMean::VertexColorMean(const Mesh& mesh) : mesh_(mesh), sums_(mesh.positions.size(), ColorSum(0)) {}

void VertexColorMean::add(const StoredView& view, const glm::dvec3& gain) {
  check(view);
  const SampleWeights weights(gain);
  for (const VertexSample& sample : samples_of(view, mesh_.positions)) sums_[sample.vertex] += weights(sample);
}

std::vector<glm::u8vec3> VertexColorMean::colors() const {
  std::vector<glm::vec4> spread_light;
  if (mesh_.colors.empty()) {
    spread_light = light_of_all(sums_);
    spread(mesh_.faces, VertexFaces(sums_.size(), mesh_.faces), spread_light);
  }
  std::vector<glm::u8vec3> colors(sums_.size());
  for (std::size_t vertex = 0; vertex < sums_.size(); ++vertex) {
    if (sums_[vertex].w > 0) {
      colors[vertex] = srgb_of(sums_[vertex]);
    } else if (!spread_light.empty() && spread_light[vertex].w > 0) {
      colors[vertex] = srgb_of(spread_light[vertex]);
    } else {
      colors[vertex] = own_color(mesh_, vertex);
    }
  }
  return colors;
}

std::shared_ptr<const VertexColors::Colors> VertexColors::of(const std::shared_ptr<const Surface>& surface,
                                                             std::span<const std::shared_ptr<const StoredView>> views,
                                                             std::span<const glm::dvec3> gains) {
  if (!surface) throw std::invalid_argument("vertex colours: surface is null");
  if (gains.size() != views.size()) {
    throw std::invalid_argument("vertex colours: there are " + std::to_string(gains.size()) +
                                " gains, must be one for " + "each of the " + std::to_string(views.size()) + " slots");
  }
  const std::scoped_lock lock(mutex_);
  try {
    // Isolated, so that this thread, where it waits for others, does not begin another task, which may ask for colours.
    tbb::this_task_arena::isolate([&] { update(surface, views, gains); });
  } catch (...) {
    surface_.reset();  // the sums may have half of the views: the next call begins anew
    throw;
  }
  return colors_;
}

std::uint64_t VertexColors::samples_counted() const {
  const std::scoped_lock lock(mutex_);
  return samples_counted_;
}

void VertexColors::update(const std::shared_ptr<const Surface>& surface,
                          std::span<const std::shared_ptr<const StoredView>> views, std::span<const glm::dvec3> gains) {
  if (surface != surface_ && !take_over(surface, views)) begin(surface);
  follow(views, gains);
  if (!any_changed_) return;
  const auto colors = std::make_shared<Colors>(place_of_vertex_.size());
  if (colors_) *colors = *colors_;
  color_changed(*colors);
  if (surface_->mesh.colors.empty()) spread(*colors);
  std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
  any_changed_ = false;
  colors_ = colors;
}

void VertexColors::begin(const std::shared_ptr<const Surface>& surface) {
  const std::size_t vertices = surface->mesh.positions.size();
  surface_.reset();
  shown_.clear();
  places_ = surface->mesh.positions;
  place_of_vertex_.resize(vertices);
  std::iota(place_of_vertex_.begin(), place_of_vertex_.end(), 0U);
  sums_.assign(vertices, ColorSum(0));
  sum_colors_.assign(vertices, glm::u8vec3(0));
  changed_.assign(vertices, 1);
  any_changed_ = true;
  spread_.clear();
  colors_.reset();
  surface_ = surface;
}

// Returns the place of each position, or PositionTable::kEmpty where it is not found soon after the one before. Most
// vertices of a surface that changes in places keep their order. Where many have gone, the search ends before its time.
std::vector<std::uint32_t> VertexColors::places_in_order(const std::vector<glm::vec3>& positions) const {
  constexpr std::size_t kLookAhead = 512;  // vertices: about as many as go at once
  std::vector<std::uint32_t> places(positions.size(), PositionTable::kEmpty);
  std::size_t next = 0;  // vertex before
  std::size_t tries = 8 * (positions.size() + place_of_vertex_.size());
  for (std::size_t vertex = 0; vertex < places.size(); ++vertex) {
    const std::size_t end = std::min(next + kLookAhead, place_of_vertex_.size());
    std::size_t same = next;
    while (same < end && places_[place_of_vertex_[same]] != positions[vertex]) ++same;
    if (same - next >= tries) break;
    tries -= same - next;
    if (same == end) continue;
    places[vertex] = place_of_vertex_[same];
    next = same + 1;
  }
  return places;
}

// Keeps the sums of vertices at the same places, and projects the others. Views that have changed too are projected
// as a whole afterwards: see follow(). Returns false where most places have gone.
bool VertexColors::take_over(const std::shared_ptr<const Surface>& surface,
                             std::span<const std::shared_ptr<const StoredView>> views) {
  if (!surface_) return false;
  const std::vector<glm::vec3>& positions = surface->mesh.positions;
  std::vector<std::uint32_t> places = places_in_order(positions);
  {
    std::vector<std::uint8_t> is_found(places_.size(), 0);
    for (const std::uint32_t place : places) {
      if (place != PositionTable::kEmpty) is_found[place] = 1;
    }
    std::vector<std::uint32_t> others = place_of_vertex_;
    std::erase_if(others, [&](std::uint32_t place) { return is_found[place] != 0; });
    const PositionTable known(places_, others);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, positions.size(), kVertexBlock),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t vertex = range.begin(); vertex != range.end(); ++vertex) {
                          if (places[vertex] == PositionTable::kEmpty) places[vertex] = known.find(positions[vertex]);
                        }
                      });
  }
  const auto fresh = static_cast<std::size_t>(std::count(places.begin(), places.end(), PositionTable::kEmpty));
  if (fresh > positions.size() / 2 || places_.size() + fresh > 2 * positions.size()) return false;
  const std::size_t first = places_.size();
  for (std::size_t vertex = 0; vertex < places.size(); ++vertex) {
    if (places[vertex] != PositionTable::kEmpty) continue;
    places[vertex] = static_cast<std::uint32_t>(places_.size());
    places_.push_back(positions[vertex]);
  }
  place_of_vertex_ = std::move(places);
  sums_.resize(places_.size(), ColorSum(0));
  sum_colors_.resize(places_.size(), glm::u8vec3(0));
  changed_.resize(places_.size(), 1);
  any_changed_ = true;
  spread_.clear();
  colors_.reset();
  surface_ = surface;
  for (std::size_t slot = 0; slot < std::min(shown_.size(), views.size()); ++slot) {
    Shown& shown = shown_[slot];
    if (!views[slot] || !is_of(shown, views[slot])) continue;
    const std::vector<VertexSample> more = samples_of(*views[slot], places_, first);
    count(more, shown.gain, Count::add);
    shown.samples.insert(shown.samples.end(), more.begin(), more.end());
  }
  return true;
}

bool VertexColors::is_of(const Shown& shown, const std::shared_ptr<const StoredView>& view) {
  return !shown.view.owner_before(view) && !view.owner_before(shown.view);
}

void VertexColors::follow(std::span<const std::shared_ptr<const StoredView>> views, std::span<const glm::dvec3> gains) {
  shown_.resize(views.size());
  for (std::size_t slot = 0; slot < views.size(); ++slot) {
    Shown& shown = shown_[slot];
    give_back_scratch_pages();
    const bool same_view = is_of(shown, views[slot]);
    if (same_view && (!views[slot] || shown.gain == gains[slot])) continue;
    count(shown.samples, shown.gain, Count::take_away);
    if (!same_view) {
      shown.samples = views[slot] ? samples_of(*views[slot], places_) : std::vector<VertexSample>{};
      shown.view = views[slot];
    }
    shown.gain = gains[slot];
    count(shown.samples, shown.gain, Count::add);
  }
}

// A view shows a vertex once at most, so that threads never meet at one.
void VertexColors::count(std::span<const VertexSample> samples, const glm::dvec3& gain, Count how) {
  if (samples.empty()) return;
  const SampleWeights weights(gain);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, samples.size(), kVertexBlock),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t i = range.begin(); i != range.end(); ++i) {
                        const VertexSample& sample = samples[i];
                        ColorSum& sum = sums_[sample.vertex];
                        sum = how == Count::add ? sum + weights(sample) : sum - weights(sample);
                        changed_[sample.vertex] = 1;
                      }
                    });
  samples_counted_ += samples.size();
  any_changed_ = true;
}

void VertexColors::color_changed(Colors& colors) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, sums_.size(), kVertexBlock),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t place = range.begin(); place != range.end(); ++place) {
                        if (changed_[place] != 0 && sums_[place].w > 0) sum_colors_[place] = srgb_of(sums_[place]);
                      }
                    });
  const bool all = !colors_;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, colors.size(), kVertexBlock),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t vertex = range.begin(); vertex != range.end(); ++vertex) {
                        const std::uint32_t place = place_of_vertex_[vertex];
                        if (!all && changed_[place] == 0) continue;
                        colors[vertex] = sums_[place].w > 0 ? sum_colors_[place] : own_color(surface_->mesh, vertex);
                      }
                    });
}

// Returns for each vertex that no view shows the colour that has spread to it, and zeros for the others. Only faces
// with such a vertex are looked at: the others pass nothing on.
std::vector<glm::vec4> VertexColors::spread_light() const {
  constexpr std::uint32_t kUnused = ~0u;
  std::vector<std::uint32_t> number(place_of_vertex_.size(), kUnused);
  std::vector<std::uint32_t> vertices;  // of the part
  std::vector<glm::uvec3> faces;
  for (glm::uvec3 face : surface_->mesh.faces) {
    if (!is_bare(face.x) && !is_bare(face.y) && !is_bare(face.z)) continue;
    for (int corner = 0; corner < 3; ++corner) {
      std::uint32_t& known = number[face[corner]];
      if (known == kUnused) {
        known = static_cast<std::uint32_t>(vertices.size());
        vertices.push_back(face[corner]);
      }
      face[corner] = known;
    }
    faces.push_back(face);
  }
  std::vector<glm::vec4> light;
  light.reserve(vertices.size());
  for (const std::uint32_t vertex : vertices) light.push_back(light_of(sums_[place_of_vertex_[vertex]]));
  lumatlas::spread(faces, VertexFaces(light.size(), faces), light);
  std::vector<glm::vec4> spread(place_of_vertex_.size(), glm::vec4(0));
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (is_bare(vertices[i])) spread[vertices[i]] = light[i];
  }
  return spread;
}

// Colours the vertices that no view shows. Changes only those to which another colour than before has spread.
void VertexColors::spread(Colors& colors) {
  const std::vector<glm::vec4> last = std::exchange(spread_, spread_light());
  tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, static_cast<std::uint32_t>(colors.size()), kVertexBlock),
                    [&](const tbb::blocked_range<std::uint32_t>& range) {
                      for (std::uint32_t vertex = range.begin(); vertex != range.end(); ++vertex) {
                        if (!is_bare(vertex)) continue;
                        const bool stays = colors_ && changed_[place_of_vertex_[vertex]] == 0 && !last.empty() &&
                                           last[vertex] == spread_[vertex];
                        if (stays) continue;
                        colors[vertex] = spread_[vertex].w > 0 ? srgb_of(spread_[vertex]) : glm::u8vec3(kMidGrey);
                      }
                    });
}

}  // namespace lumatlas
