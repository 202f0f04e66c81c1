// SPDX-License-Identifier: GPL-3.0-or-later
// The colours of a surface's vertices that a snapshot shows where no view is valid. They are made when they are asked
// for the first time, so that a snapshot that nothing draws or writes costs nothing for them.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/gtc/type_precision.hpp>
#include <memory>
#include <vector>

namespace lumatlas {

// Copies share the colours, whether they are made already or not. Safe to use from several threads at once.
class FallbackColors {
 public:
  using Colors = std::vector<glm::u8vec3>;  // sRGB, one per vertex

  FallbackColors() : FallbackColors(Colors()) {}
  // Colours that are there already, as those of a model that was read.
  FallbackColors(Colors given);  // NOLINT(google-explicit-constructor): a list of colours is one of these
  // `make` is called at most once that it returns, by the first thread that asks, and must return as many colours as
  // `vertices` says, never null. Until then it keeps alive what it holds.
  FallbackColors(std::size_t vertices, std::function<std::shared_ptr<const Colors>()> make);

  // Returns the number of vertices; makes nothing.
  [[nodiscard]] std::size_t size() const;
  // Returns whether the colours are there already.
  [[nodiscard]] bool are_made() const;
  // Returns the colours, and makes them if they are not there yet. Good as long as any copy of this object. Throws
  // whatever `make` throws; the next call tries again.
  [[nodiscard]] const Colors& get() const;

  // Makes the colours of both, unless they are the same object's.
  friend bool operator==(const FallbackColors& a, const FallbackColors& b);

 private:
  struct State;
  std::shared_ptr<State> state_;  // never null
};

// The colours of the first `vertices` vertices, which there must be; made when they are asked for.
[[nodiscard]] FallbackColors first_of(const FallbackColors& colors, std::size_t vertices);

}  // namespace lumatlas
