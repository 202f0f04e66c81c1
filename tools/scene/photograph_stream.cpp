// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/photograph_stream.h"

#include <stdexcept>
#include <string>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::size_t kReadAhead = 2;  // enough to hide the disk, and no more memory than that

}  // namespace

PhotographStream::PhotographStream(const std::vector<SceneView>& views, std::vector<std::size_t> ranks)
    : views_(views), ranks_(std::move(ranks)) {
  for (const std::size_t rank : ranks_) {
    if (rank < views_.size()) continue;
    throw std::invalid_argument("photograph stream: a rank is " + std::to_string(rank) +
                                ", must be below the number of views, " + std::to_string(views_.size()));
  }
  read_ahead();
}

Photograph PhotographStream::next() {
  if (pending_.empty()) throw std::logic_error("photograph stream: next() after the last photograph");
  std::future<Photograph> photograph = std::move(pending_.front());
  pending_.pop_front();
  read_ahead();
  return photograph.get();
}

void PhotographStream::read_ahead() {
  while (pending_.size() < kReadAhead && requested_ < ranks_.size()) {
    const SceneView& view = views_[ranks_[requested_++]];
    pending_.push_back(std::async(std::launch::async, [&view] { return load_photograph(view); }));
  }
}

}  // namespace lumatlas
