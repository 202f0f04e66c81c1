// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/visibility/piecewise_looks.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "mesh/visibility/shown_box.h"

namespace lumatlas {

namespace {

std::size_t pixels_of(const Camera& camera) {
  return std::size_t{camera.width} * camera.height;
}

VisibilityBuffer empty_picture(const Camera& camera) {
  VisibilityBuffer picture;
  picture.width = camera.width;
  picture.height = camera.height;
  picture.depth.assign(pixels_of(camera), std::numeric_limits<float>::infinity());
  picture.face.assign(pixels_of(camera), FaceId::none);
  return picture;
}

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

// Adds what the cameras see of one piece.
void look_at(const MeshPiece& piece, std::size_t first_face, std::span<const Camera> cameras,
             std::vector<VisibilityBuffer>& pictures) {
  std::vector<std::size_t> looking;
  for (std::size_t camera = 0; camera < cameras.size(); ++camera) {
    const ShownBox shown = shown_box(cameras[camera], piece.box);
    if (!shown.empty() && may_show(shown, pictures[camera])) looking.push_back(camera);
  }
  if (looking.empty()) return;
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(piece.load());
  tbb::parallel_for(std::size_t{0}, looking.size(), [&](std::size_t i) {
    add_nearer(visibility->trace(cameras[looking[i]]), first_face, pictures[looking[i]]);
  });
}

}  // namespace

void look_at_pieces(const std::vector<MeshPiece>& pieces, std::span<const Camera> cameras, std::uint64_t picture_bytes,
                    const std::function<void(std::size_t camera, const VisibilityBuffer& seen)>& use,
                    const CancelCheck& cancel_check) {
  for (const Camera& camera : cameras) check(camera);
  for (std::size_t first = 0; first < cameras.size();) {
    std::uint64_t bytes = 0;
    std::vector<VisibilityBuffer> pictures;
    while (first + pictures.size() < cameras.size()) {
      const Camera& camera = cameras[first + pictures.size()];
      bytes += pixels_of(camera) * (sizeof(float) + sizeof(FaceId));
      if (!pictures.empty() && bytes > picture_bytes) break;
      pictures.push_back(empty_picture(camera));
    }
    std::size_t first_face = 0;
    for (const MeshPiece& piece : pieces) {
      check_cancelled(cancel_check);
      look_at(piece, first_face, cameras.subspan(first, pictures.size()), pictures);
      first_face += piece.faces;
    }
    for (std::size_t i = 0; i < pictures.size(); ++i) use(first + i, pictures[i]);
    first += pictures.size();
  }
}

}  // namespace lumatlas
