// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/piecewise_visibility.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

#include "mesh/visibility/shown_box.h"

namespace lumatlas {

namespace {

// Returns whether some pixel that may show the box shows nothing before it yet.
bool may_show(const ShownBox& shown, const VisibilityBuffer& seen) {
  for (std::uint32_t y = shown.top; y < shown.bottom; ++y) {
    for (std::uint32_t x = shown.left; x < shown.right; ++x) {
      if (static_cast<double>(seen.depth[std::size_t{y} * seen.width + x]) > shown.near) return true;
    }
  }
  return false;
}

void add_nearer(const VisibilityBuffer& of_piece, std::size_t first_face, VisibilityBuffer& seen) {
  for (std::size_t pixel = 0; pixel < seen.depth.size(); ++pixel) {
    if (of_piece.face[pixel] == FaceId::none || of_piece.depth[pixel] >= seen.depth[pixel]) continue;
    seen.depth[pixel] = of_piece.depth[pixel];
    seen.face[pixel] = FaceId(static_cast<std::uint32_t>(first_face) + of_piece.face[pixel]);
  }
}

}  // namespace

PiecewiseVisibility::PiecewiseVisibility(std::vector<MeshPiece> pieces, std::size_t most_faces)
    : pieces_(std::move(pieces)), most_faces_(most_faces) {
  std::size_t faces = 0;
  for (const MeshPiece& piece : pieces_) {
    first_face_.push_back(faces);
    faces += piece.faces;
  }
}

void PiecewiseVisibility::trace(const Camera& camera, VisibilityBuffer& buffer) const {
  check(camera);
  const std::size_t pixels = std::size_t{camera.width} * camera.height;
  buffer.width = camera.width;
  buffer.height = camera.height;
  buffer.depth.assign(pixels, std::numeric_limits<float>::infinity());
  buffer.face.assign(pixels, FaceId::none);
  std::vector<std::pair<ShownBox, std::size_t>> order;
  for (std::size_t piece = 0; piece < pieces_.size(); ++piece) {
    const ShownBox shown = shown_box(camera, pieces_[piece].box);
    if (!shown.empty()) order.emplace_back(shown, piece);
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first.near != b.first.near ? a.first.near < b.first.near : a.second < b.second;
  });
  VisibilityBuffer of_piece;
  for (const auto& [shown, piece] : order) {
    if (!may_show(shown, buffer)) continue;
    visibility_of(piece)->trace(camera, of_piece);
    add_nearer(of_piece, first_face_[piece], buffer);
  }
}

std::size_t PiecewiseVisibility::loads() const {
  const std::lock_guard lock(mutex_);
  return loads_;
}

std::shared_ptr<const Visibility> PiecewiseVisibility::visibility_of(std::size_t piece) const {
  {
    const std::lock_guard lock(mutex_);
    const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.piece == piece; });
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return found->visibility;
    }
    // Room is made first, so that no more than the bound and this piece are in memory.
    while (!kept_.empty() && kept_faces_ + pieces_[piece].faces > most_faces_) {
      kept_faces_ -= pieces_[kept_.back().piece].faces;
      kept_.pop_back();
    }
    ++loads_;
  }
  std::shared_ptr<const Visibility> made = make_ray_visibility(pieces_[piece].load());
  const std::lock_guard lock(mutex_);
  const bool known = std::any_of(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.piece == piece; });
  if (!known) {
    kept_.push_front({piece, made});
    kept_faces_ += pieces_[piece].faces;
  }
  return made;
}

}  // namespace lumatlas
