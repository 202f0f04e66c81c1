// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/budget/held_out_loss.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <iterator>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "planner/pruning/hindsight.h"
#include "planner/tile_choice.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

// The folds leave out as many photographs at once as `--hold 8`. With fewer folds a store of the others would be too
// sparse to stand for the whole one.
constexpr std::size_t kFolds = 8;
constexpr std::size_t kMostPictures = 12;   // pictures of a fold
constexpr std::size_t kFewestPictures = 4;  // in all, that a standard error can be told from
constexpr std::size_t kLeastToDecide = 24;  // pictures
constexpr double kErrorsToDecide = 4;       // standard errors; many, for pictures of a fold share its store
constexpr double kPixelsInAll = kFolds * kMostPictures * 256 * 256;
constexpr double kLeastSidePx = 256, kMostSidePx = 512;  // a picture's
constexpr std::uint8_t kLeastTrust = 128;                // least StoredView::trust
constexpr double kLeastShare = 0.2;                      // share of a picture's pixels that must be comparable
constexpr double kMostPsnr = 78;                         // dB, so that equal pictures have one

// The fractional parts of multiples of an irrational number are spread evenly however many they are.
double spread(std::size_t index, double step) {
  double whole = 0;
  return std::modf(0.5 + step * static_cast<double>(index), &whole);
}

std::vector<ViewSlot> stored_slots(const Snapshot& store) {
  std::vector<ViewSlot> slots;
  for (ViewSlot slot{0}; slot < store.views.size(); ++slot) {
    if (store.views[slot]) slots.push_back(slot);
  }
  return slots;
}

// A view that is left out lends nothing: neither colours nor its exposure.
void leave_out(ViewSlot slot, Snapshot& store) {
  TileTable& tiles = store.tiles;
  if (tiles.whole_views()) {
    store.views[slot].reset();
    store.gains[slot] = glm::dvec3(1);
  } else {
    std::fill(tiles.places.begin() + tiles.first_tile[slot], tiles.places.begin() + tiles.first_tile[slot + 1],
              TilePlace::none);
  }
}

double mean_of(const std::vector<double>& losses) {
  return std::accumulate(losses.begin(), losses.end(), 0.0) / static_cast<double>(losses.size());
}

MeasuredLoss loss_of(const std::vector<double>& losses) {
  const auto count = static_cast<double>(losses.size());
  const double mean = mean_of(losses);
  double squares = 0;
  for (const double loss : losses) squares += (loss - mean) * (loss - mean);
  return {mean, std::sqrt(squares / (count * std::max(count - 1, 1.0))), 0};
}

// Returns whether more pictures would hardly change on which side of the bound the loss is.
bool is_decided(const std::vector<double>& losses, double bound_db) {
  if (losses.size() < kLeastToDecide) return false;
  const MeasuredLoss loss = loss_of(losses);
  return std::abs(loss.mean_db - bound_db) > kErrorsToDecide * loss.error_db;
}

}  // namespace

HeldOutLoss::Picture HeldOutLoss::picture_of(const StoredView& view, std::uint32_t side_px, std::size_t index) {
  // Reciprocals of the plastic number and of its square, for points of the plane.
  constexpr double kAcross = 0.7548776662466927, kDown = 0.5698402909980532;
  const Camera& whole = view.camera;
  Picture picture{whole, {}, {}, {}};
  picture.camera.width = std::min(side_px, whole.width);
  picture.camera.height = std::min(side_px, whole.height);
  const auto left = static_cast<std::uint32_t>(spread(index, kAcross) * (whole.width - picture.camera.width + 1));
  const auto top = static_cast<std::uint32_t>(spread(index, kDown) * (whole.height - picture.camera.height + 1));
  picture.camera.cx -= left;
  picture.camera.cy -= top;
  picture.photograph.width = picture.camera.width;
  picture.photograph.height = picture.camera.height;
  for (std::uint32_t y = 0; y < picture.camera.height; ++y) {
    for (std::uint32_t x = 0; x < picture.camera.width; ++x) {
      const std::size_t pixel = std::size_t{top + y} * whole.width + left + x;
      const StoredPhotograph::Color rgb = view.photograph->color(pixel);
      picture.photograph.rgb.insert(picture.photograph.rgb.end(), rgb.begin(), rgb.end());
      const bool in_lens = view.photograph->is_inside_lens(pixel);
      picture.counts.push_back(in_lens && (view.mask->trust.empty() || view.mask->trust[pixel] >= kLeastTrust) ? 1 : 0);
    }
  }
  return picture;
}

HeldOutLoss::HeldOutLoss(const Planner& planner, const Atlas& atlas, BuildStage& stage)
    : planner_(planner),
      atlas_(atlas),
      stage_(stage),
      store_(atlas.snapshot()),
      // Cells are joined in the first snapshot alone, which would differ from all that are compared with it.
      renderer_({.join_cells = false}) {
  deal(stored_slots(store_));
  for (Fold& fold : folds_) {
    load(fold, {});
    for (Picture& picture : fold.pictures) compare_with_whole(picture);
    std::erase_if(fold.pictures, [](const Picture& picture) {
      const auto compared = std::count(picture.counts.begin(), picture.counts.end(), 1);
      return static_cast<double>(compared) < kLeastShare * static_cast<double>(picture.counts.size());
    });
    stage_.tick();
  }
}

// Views in neighbouring slots, which mostly came one after the other, go into different folds.
void HeldOutLoss::deal(const std::vector<ViewSlot>& slots) {
  folds_.resize(std::min(kFolds, slots.size()));
  std::size_t pictures = 0;
  for (std::size_t f = 0; f < folds_.size(); ++f) {
    Fold& fold = folds_[f];
    for (std::size_t place = f; place < slots.size(); place += folds_.size()) fold.absent.push_back(slots[place]);
    pictures += std::min(kMostPictures, fold.absent.size());
  }
  const double side = std::sqrt(kPixelsInAll / static_cast<double>(std::max<std::size_t>(pictures, 1)));
  const auto side_px = static_cast<std::uint32_t>(std::clamp(side, kLeastSidePx, kMostSidePx));
  std::size_t index = 0;
  for (Fold& fold : folds_) {
    const std::size_t count = std::min(kMostPictures, fold.absent.size());
    for (std::size_t i = 0; i < count; ++i) {
      const ViewSlot slot = fold.absent[i * fold.absent.size() / count];
      fold.pictures.push_back(picture_of(*store_.views[slot], side_px, index++));
    }
  }
}

std::vector<ViewSlot> HeldOutLoss::kept_of(Fold& fold, std::optional<double> gap) const {
  std::vector<ViewSlot> gone = fold.absent;
  if (gap && fold.order.empty()) fold.order = Hindsight(planner_).thinning_order(fold.absent);
  for (const ThinningStep& step : fold.order) {
    if (gap && step.gap <= *gap) gone.push_back(step.slot);
  }
  std::vector<ViewSlot> kept = stored_slots(store_);
  std::erase_if(kept, [&](ViewSlot slot) { return std::find(gone.begin(), gone.end(), slot) != gone.end(); });
  return kept;
}

void HeldOutLoss::load(Fold& fold, const GivenUp& given_up) {
  const std::vector<ViewSlot> kept = kept_of(fold, given_up.gap);
  Snapshot store = store_;  // its photographs are shared
  store.references = Hindsight(planner_).references_among(kept, fold.absent, given_up.reference_loss_db);
  for (ViewSlot slot{0}; slot < store.views.size(); ++slot) {
    if (!std::binary_search(kept.begin(), kept.end(), slot)) leave_out(slot, store);
  }
  leave_out_views_without_tiles(store);
  if (given_up.tile_share < 1) keep_tiles(given_up.tile_share, store);
  renderer_.load(store);
}

// Keeps as many tiles as the whole store keeps, because a picture in between finds that many around it, and would find
// fewer of a share of the fold's tiles. It never keeps quite all tiles of the fold, because some are given up.
void HeldOutLoss::keep_tiles(double share, Snapshot& store) const {
  TileTable& tiles = store.tiles;
  std::vector<SharedShownCells> shown;
  for (ViewSlot slot{0}; slot < store.views.size(); ++slot) {
    auto resident = std::make_shared<std::vector<ShownCell>>();
    if (store.views[slot]) {
      const SharedShownCells parts = atlas_.shown(slot);
      std::copy_if(parts->begin(), parts->end(), std::back_inserter(*resident),
                   [&, first = tiles.first_tile[slot]](const ShownCell& part) {
                     return tiles.places[first + part.tile] != TilePlace::none;
                   });
    }
    shown.push_back(std::move(resident));
  }
  const double of_fold = tiles.resident_tiles(), of_whole = store_.tiles.resident_tiles();
  const auto kept = static_cast<std::size_t>(std::min(share * of_whole, (1 + share) / 2 * of_fold));
  TileChoice choice =
      choose_tiles({*store.surface, store.views, shown, store.references, std::max<std::size_t>(kept, 1), {}});
  std::vector<TilePlace> slots(tiles.places.size(), TilePlace::none);
  for (const ViewTile& tile : choice.tiles) {
    const std::size_t place = tiles.first_tile[tile.view] + tile.tile;
    slots[place] = tiles.places[place];
  }
  tiles.places = std::move(slots);
  store.references = std::move(choice.references);
  leave_out_views_without_tiles(store);
}

// Pixels count that views of the whole store are blended for, whatever is left of these views later.
void HeldOutLoss::compare_with_whole(Picture& picture) {
  const Rendering drawn = draw(picture);
  for (std::size_t pixel = 0; pixel < picture.counts.size(); ++pixel) {
    if (drawn.state[pixel] != PixelState::textured) picture.counts[pixel] = 0;
  }
  picture.whole = {psnr_of(picture, drawn), ssim(drawn.picture, picture.photograph, picture.counts)};
}

Rendering HeldOutLoss::draw(const Picture& picture) {
  throw_if_interrupted();
  BlendOptions options;
  options.supersample = 1;  // which is quicker, and changes all pictures alike
  return renderer_.render(picture.camera, options);
}

double HeldOutLoss::psnr_of(const Picture& picture, const Rendering& drawn) {
  return std::min(psnr(drawn.picture, picture.photograph, picture.counts), kMostPsnr);
}

bool HeldOutLoss::can_tell() const {
  std::size_t pictures = 0;
  for (const Fold& fold : folds_) pictures += fold.pictures.size();
  return pictures >= kFewestPictures;
}

MeasuredLoss HeldOutLoss::now(const GivenUp& given_up, std::optional<double> bound_db) {
  if (!can_tell()) throw std::logic_error("held-out loss: too few photographs show what others show");
  if (given_up.tile_share < 1 && atlas_.layout().whole_views()) {
    throw std::logic_error("held-out loss: whole views have no tiles to give up");
  }
  const auto surface = std::exchange(store_, atlas_.snapshot()).surface;
  if (store_.surface != surface) {
    for (Fold& fold : folds_) fold.order.clear();
  }
  std::vector<double> losses, ssim_losses;
  for (Fold& fold : folds_) {
    if (fold.pictures.empty()) continue;
    load(fold, given_up);
    for (const Picture& picture : fold.pictures) {
      const Rendering drawn = draw(picture);
      losses.push_back(picture.whole.psnr - psnr_of(picture, drawn));
      if (bound_db) continue;
      ssim_losses.push_back(picture.whole.ssim - ssim(drawn.picture, picture.photograph, picture.counts));
    }
    stage_.tick();
    if (bound_db && is_decided(losses, *bound_db)) break;
  }
  MeasuredLoss loss = loss_of(losses);
  if (!bound_db) loss.ssim = mean_of(ssim_losses);
  return loss;
}

}  // namespace lumatlas
