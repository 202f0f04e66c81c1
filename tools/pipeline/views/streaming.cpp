// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/views/streaming.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>

#include "mesh/base/errors.h"
#include "tools/base/elapsed.h"
#include "tools/pipeline/views/sharpness.h"

namespace lumatlas {

namespace {

// Gives a view's photograph when it is asked for, and notes how long reading took.
PhotographSource photograph_of(const SceneView& view, PlannedView& planned) {
  return [&view, &planned] {
    const auto start = std::chrono::steady_clock::now();
    Photograph read = load_photograph(view);
    planned.read_ms = ms_since(start);
    return read;
  };
}

}  // namespace

Stream stream_of(const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  Stream stream;
  stream.reserve(ranks.size());
  for (const std::size_t rank : ranks) stream.push_back(&views[rank]);
  return stream;
}

Stream stream_of(const std::vector<SceneView>& views) {
  Stream stream;
  for (const SceneView& view : views) stream.push_back(&view);
  return stream;
}

void require_names_that_a_model_can_hold(const Stream& stream) {
  for (const SceneView* view : stream) {
    try {
      (void)nlohmann::json(view->name).dump();
    } catch (const nlohmann::json::type_error&) {
      throw InputError(view->image.string() +
                       ": its name is not UTF-8, which a model needs: rename the photograph, in the scene's list too");
    }
  }
}

void require_room_for_each(const Stream& stream, const BuildOptions& options, std::uint64_t max_bytes) {
  if (max_bytes == 0) return;
  const bool whole_views = options.tiles.whole_views();
  for (const SceneView* view : stream) {
    const std::uint64_t bytes = stored_bytes(view->camera);
    if (bytes <= max_bytes) continue;
    throw InputError(view->image.string() + ": takes " + std::to_string(bytes) + " bytes in the store, more than the " +
                     (whole_views ? "budget of " : "") + std::to_string(max_bytes) +
                     (whole_views ? "" : " for photographs") + ": give at least that as " +
                     (whole_views ? "--budget" : "--photograph-bytes"));
  }
}

PlannedView Streaming::offer(const SceneView& view) {
  PlannedView planned;
  planned.name = view.name;
  planned.verdict = planner_.offer(view.name, view.camera, photograph_of(view, planned));
  planned.summed_coverage = planner_.store().summed_coverage();
  return planned;
}

void Streaming::offer_all(const Stream& stream) {
  BuildStage stage(callback_, "planning views", stream.size());
  for (const SceneView* view : stream) {
    result_.planned.push_back(offer(*view));
    refinement_.after_offer();
    stage.tick();
  }
  stage.finish();
}

void Streaming::keep_chosen(const Stream& stream, const std::vector<std::size_t>& chosen) {
  BuildStage stage(callback_, "planning views", stream.size());
  for (std::size_t place = 0; place < stream.size(); ++place) {
    const SceneView& view = *stream[place];
    PlannedView planned;
    planned.name = view.name;
    if (std::binary_search(chosen.begin(), chosen.end(), place)) {
      planned.verdict = planner_.force_store(view.name, view.camera, photograph_of(view, planned));
    } else {
      planner_.count_demand(view.camera);
    }
    planned.summed_coverage = planner_.store().summed_coverage();
    result_.planned.push_back(std::move(planned));
    refinement_.after_offer();
    stage.tick();
  }
  stage.finish();
}

// A photograph that cannot be read counts as sharp: if it is chosen, the user is told.
std::vector<double> Streaming::sharpness_of(const Stream& stream) const {
  constexpr std::size_t kAtOnce = 16;  // photographs between two reports of progress
  std::vector<Camera> cameras;
  for (const SceneView* view : stream) cameras.push_back(view->camera);
  std::vector<std::optional<double>> details(stream.size());
  BuildStage stage(callback_, "looking for blurred photographs", stream.size());
  for (std::size_t first = 0; first < stream.size(); first += kAtOnce) {
    const std::size_t end = std::min(first + kAtOnce, stream.size());
    tbb::parallel_for(first, end, [&](std::size_t place) {
      try {
        details[place] = fine_detail(load_photograph(*stream[place]));
      } catch (const InputError&) {
        details[place].reset();
      }
    });
    for (std::size_t place = first; place < end; ++place) stage.tick();
  }
  stage.finish();
  return relative_sharpness(cameras, details);
}

// Returns the places in the stream of the views that the store would hold at its end, ascending.
std::vector<std::size_t> Streaming::reserve_all(const Stream& stream, bool sharp_first) {
  const std::vector<double> sharpness = sharp_first ? sharpness_of(stream) : std::vector<double>(stream.size(), 1);
  BuildStage stage(callback_, "planning views", stream.size());
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const SceneView* const view = stream[i];
    PlannedView planned;
    planned.name = view->name;
    planned.verdict = planner_.reserve(view->name, view->camera, sharpness[i]);
    planned.summed_coverage = planner_.store().summed_coverage();
    result_.planned.push_back(std::move(planned));
    stage.tick();
  }
  stage.finish();
  std::vector<std::size_t> places;
  for (std::size_t place = 0; place < stream.size(); ++place) {
    const PlannedView& planned = result_.planned[place];
    if (planned.verdict.slot && planner_.store().promised_camera(planned.name, *planned.verdict.slot) != nullptr)
      places.push_back(place);
  }
  return places;
}

// Offers the room of outliers to all the others.
void Streaming::refill(const Stream& stream, const std::vector<std::size_t>& filled) {
  BuildStage stage(callback_, "planning again", stream.size());
  for (std::size_t place = 0; place < stream.size(); ++place) {
    if (!std::binary_search(filled.begin(), filled.end(), place)) {
      const SceneView& view = *stream[place];
      PlannedView& planned = result_.planned[place];
      Verdict verdict = planner_.offer_again(view.name, view.camera, photograph_of(view, planned));
      if (verdict.decision != Decision::rejected) planned.verdict = std::move(verdict);
      refinement_.after_offer();
    }
    stage.tick();
  }
  stage.finish();
}

void Streaming::plan_ahead(const Stream& stream, bool sharp_first) {
  const std::vector<std::size_t> places = reserve_all(stream, sharp_first);
  bool outliers = false;
  BuildStage stage(callback_, "storing views", places.size());
  for (const std::size_t place : places) {
    PlannedView& planned = result_.planned[place];
    planner_.store_reserved(planned.name, photograph_of(*stream[place], planned), planned.verdict);
    outliers = outliers || planned.verdict.decision == Decision::outlier;
    refinement_.after_offer();
    stage.tick();
  }
  stage.finish();
  if (outliers) refill(stream, places);
}

void Streaming::run_watched(WatchedScene& scene, std::vector<SceneView>& views) {
  views.clear();
  BuildStage stage(callback_, "planning views", 0);
  while (std::optional<SceneView> view = scene.next()) {
    refinement_.before_offer(*view);
    try {
      const Stream alone{&*view};
      require_names_that_a_model_can_hold(alone);
      require_room_for_each(alone, result_.options, result_.effective.max_bytes);
      result_.planned.push_back(offer(*view));
    } catch (const InputError& error) {
      scene.give_back(*view, error.what());  // it may still be being written
      continue;
    }
    views.push_back(*view);
    refinement_.after_offer();
    stage.tick();
  }
  stage.finish();
}

}  // namespace lumatlas
