// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/colors/fallback_colors.h"

#include <atomic>
#include <mutex>
#include <utility>

namespace lumatlas {

struct FallbackColors::State {
  std::size_t vertices = 0;
  std::atomic<const Colors*> made{nullptr};             // the colours, once they are there
  std::mutex mutex;                                     // guards what follows
  std::function<std::shared_ptr<const Colors>()> make;  // empty once it has made them
  std::shared_ptr<const Colors> colors;
};

FallbackColors::FallbackColors(Colors given) : state_(std::make_shared<State>()) {
  state_->vertices = given.size();
  state_->colors = std::make_shared<const Colors>(std::move(given));
  state_->made = state_->colors.get();
}

FallbackColors::FallbackColors(std::size_t vertices, std::function<std::shared_ptr<const Colors>()> make)
    : state_(std::make_shared<State>()) {
  state_->vertices = vertices;
  state_->make = std::move(make);
}

std::size_t FallbackColors::size() const {
  return state_->vertices;
}

bool FallbackColors::are_made() const {
  return state_->made != nullptr;
}

const FallbackColors::Colors& FallbackColors::get() const {
  if (const Colors* const made = state_->made) return *made;
  std::function<std::shared_ptr<const Colors>()> done;  // freed after the lock, with what it kept alive
  const std::scoped_lock lock(state_->mutex);
  if (!state_->colors) {
    state_->colors = state_->make();
    state_->made = state_->colors.get();
    done.swap(state_->make);
  }
  return *state_->colors;
}

bool operator==(const FallbackColors& a, const FallbackColors& b) {
  if (a.state_ == b.state_) return true;
  if (a.size() != b.size()) return false;
  const FallbackColors::Colors &colors = a.get(), &others = b.get();
  return &colors == &others || colors == others;
}

FallbackColors first_of(const FallbackColors& colors, std::size_t vertices) {
  return {vertices, [colors, vertices] {
            const FallbackColors::Colors& all = colors.get();
            return std::make_shared<const FallbackColors::Colors>(all.begin(),
                                                                  all.begin() + static_cast<std::ptrdiff_t>(vertices));
          }};
}

}  // namespace lumatlas
