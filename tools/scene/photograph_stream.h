// SPDX-License-Identifier: GPL-3.0-or-later
// Photographs of a list of views, in order, read ahead on another thread while the caller works on the last one.
#pragma once

#include <cstddef>
#include <deque>
#include <future>
#include <vector>

#include "tools/scene/scene.h"

namespace lumatlas {

class PhotographStream {
 public:
  // `views` must outlive the stream; `ranks` are indices into it (std::invalid_argument).
  PhotographStream(const std::vector<SceneView>& views, std::vector<std::size_t> ranks);

  // The next photograph. Throws what load_photograph throws, and std::logic_error once all have been given.
  [[nodiscard]] Photograph next();

 private:
  void read_ahead();

  const std::vector<SceneView>& views_;
  std::vector<std::size_t> ranks_;
  std::size_t requested_ = 0;
  std::deque<std::future<Photograph>> pending_;
};

}  // namespace lumatlas
