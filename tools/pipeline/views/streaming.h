// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to tools/pipeline/: the views of a scene go to the planner, one after the other, in one of several ways.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "planner/planner.h"
#include "tools/budget/build_progress.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/refinement/stream_refinement.h"
#include "tools/pipeline/watched_scene.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// The views in the order in which they are offered.
using Stream = std::vector<const SceneView*>;

// Returns those of these ranks, in their order, or all.
[[nodiscard]] Stream stream_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks);
[[nodiscard]] Stream stream_of(const std::vector<SceneView>& views);

// A model is JSON, whose texts are UTF-8: under another name a view could not be found again. Throws InputError.
void require_names_that_a_model_can_hold(const Stream& stream);
// Throws InputError for a view that alone takes more than `max_bytes` (0: no bound), as stored_bytes() counts.
void require_room_for_each(const Stream& stream, const BuildOptions& options, std::uint64_t max_bytes);

// Shows progress, and notes in the result what became of each view. What is thrown: what load_photograph() and the
// planner throw, and BuildStopped.
class Streaming {
 public:
  // All must outlive this object.
  Streaming(Planner& planner, StreamRefinement& refinement, const BuildCallback& callback, BuildResult& result)
      : planner_(planner), refinement_(refinement), callback_(callback), result_(result) {}

  // Offers view by view, without knowledge of the views to come.
  void offer_all(const Stream& stream);
  // Stores the views at these places of the stream, ascending, whatever they are worth.
  void keep_chosen(const Stream& stream, const std::vector<std::size_t>& chosen);
  // All cameras are known before the first photograph is read. So the planner goes through them first, and only the
  // photographs that are still in the store at the end of the stream are refined and stored. `sharp_first`: they are
  // all read before that, to see which ones are blurred.
  void plan_ahead(const Stream& stream, bool sharp_first);
  // Offers views as they come, until no more come. Leaves in `views` what was offered, in that order.
  void run_watched(WatchedScene& scene, std::vector<SceneView>& views);

 private:
  [[nodiscard]] PlannedView offer(const SceneView& view);
  [[nodiscard]] std::vector<double> sharpness_of(const Stream& stream) const;
  [[nodiscard]] std::vector<std::size_t> reserve_all(const Stream& stream, bool sharp_first);
  void refill(const Stream& stream, const std::vector<std::size_t>& filled);

  Planner& planner_;
  StreamRefinement& refinement_;
  const BuildCallback& callback_;
  BuildResult& result_;
};

}  // namespace lumatlas
