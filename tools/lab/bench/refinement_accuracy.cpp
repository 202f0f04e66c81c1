// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/bench/refinement_accuracy.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <iomanip>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/median.h"
#include "mesh/base/number_text.h"
#include "tools/lab/synth/errors/disturbance.h"
#include "tools/lab/synth/truth.h"
#include "tools/score/measures/pose_error.h"
#include "tools/score/report/json_fields.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr double kWorse_px = 0.05;  // more than this, so that noise does not count
constexpr double kFine_px = 0.5;    // found well: half a pixel is not to be seen in a blend
constexpr std::uint8_t kLeastTrust = 128;

using Truth = std::map<std::string, TrueView>;

const TrueView& truth_of(const Truth& truth, const std::filesystem::path& scene, const std::string& name) {
  const auto found = truth.find(name);
  if (found == truth.end()) {
    throw InputError((scene / "truth").string() + ": has no view " + name + ", which " + (scene / "sparse").string() +
                     " has: make the scene again with `lumatlas synth`");
  }
  return found->second;
}

std::map<std::string, Camera> given_cameras(const std::filesystem::path& scene, const glm::dvec3& offset) {
  std::map<std::string, Camera> cameras;
  for (const SceneView& view : read_scene_views(scene, offset).views) cameras.emplace(view.name, view.camera);
  return cameras;
}

// The stored view of each name, and its gain.
struct Stored {
  const StoredView* view;
  glm::dvec3 gain;
};
std::map<std::string, Stored> stored_views(const Snapshot& snapshot) {
  std::map<std::string, Stored> stored;
  for (std::size_t slot = 0; slot < snapshot.views.size(); ++slot) {
    if (snapshot.views[slot]) stored[snapshot.views[slot]->name] = {snapshot.views[slot].get(), snapshot.gains[slot]};
  }
  return stored;
}

void add_mask(const StoredView& view, const TrueView& truth, MaskAccuracy& masks) {
  const Photograph mask = truth.mask ? read_photograph(*truth.mask) : Photograph{};
  const std::size_t pixels = std::size_t{view.camera.width} * view.camera.height;
  if (truth.mask && mask.rgb.size() != 3 * pixels) {
    throw InputError(truth.mask->string() + ": is " + size_text(mask.width, mask.height) +
                     " pixels, but its photograph is " + size_text(view.camera.width, view.camera.height));
  }
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    const bool hidden = truth.mask && mask.rgb[3 * pixel] >= 128;
    const bool distrusted = !view.mask->trust.empty() && view.mask->trust[pixel] < kLeastTrust;
    masks.hidden += hidden;
    masks.distrusted += distrusted;
    masks.both += hidden && distrusted;
  }
}

// Fills in the pose errors of the stored views, pairs[i] being of views[i]. Wrong views have no say in the common
// motion.
void measure_poses(const std::vector<PosePair>& pairs, const std::map<std::string, Camera>& given,
                   std::vector<ViewAccuracy>& views) {
  std::vector<PosePair> good;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (views[i].pose && !views[i].wrong) good.push_back(pairs[i]);
  }
  const RigidMotion motion = common_motion(good);
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].pose) continue;
    const PosePair& pair = pairs[i];
    const auto error = [&](const Camera& camera) { return synth::displacement_px(pair.truth, camera, pair.points); };
    views[i].pose =
        PoseError{error(given.at(views[i].name)), error(pair.measured), error(before_motion(pair.measured, motion))};
  }
}

std::vector<const ViewAccuracy*> stored_good_views(const RefinementAccuracy& accuracy) {
  std::vector<const ViewAccuracy*> views;
  for (const ViewAccuracy& view : accuracy.views) {
    if (view.pose && !view.wrong) views.push_back(&view);
  }
  return views;
}

json json_spread(const std::vector<const ViewAccuracy*>& views, double PoseError::*field) {
  std::vector<double> values;
  values.reserve(views.size());
  for (const ViewAccuracy* view : views) values.push_back((*view->pose).*field);
  return {{"median", json_number(percentile(values, 0.5))}, {"p95", json_number(percentile(values, 0.95))}};
}

template <typename Views, typename Holds>
json share(const Views& views, const Holds& holds) {
  if (views.empty()) return nullptr;
  return static_cast<double>(std::count_if(views.begin(), views.end(), holds)) / static_cast<double>(views.size());
}

// Standard deviation over the views about each channel's mean, root mean square of the channels.
json exposure_error_ev(const std::vector<const ViewAccuracy*>& views, glm::dvec3 ViewAccuracy::*gain) {
  if (views.empty()) return nullptr;
  const auto count = static_cast<double>(views.size());
  glm::dvec3 mean(0.0), squares(0.0);
  for (const ViewAccuracy* view : views) mean += glm::log2(view->*gain) / count;
  for (const ViewAccuracy* view : views) {
    const glm::dvec3 off = glm::log2(view->*gain) - mean;
    squares += off * off / count;
  }
  return std::sqrt((squares.r + squares.g + squares.b) / 3);
}

json json_wrong_poses(const RefinementAccuracy& accuracy) {
  std::vector<const ViewAccuracy*> wrong, good;
  for (const ViewAccuracy& view : accuracy.views) (view.wrong ? wrong : good).push_back(&view);
  const auto dropped = [](const ViewAccuracy* view) { return view->decision == Decision::outlier; };
  const auto corrected = [](const ViewAccuracy* view) { return view->pose && view->pose->relative_px <= kFound_px; };
  const auto harmful = [&](const ViewAccuracy* view) { return view->pose && !corrected(view); };
  return {{"views", wrong.size()},
          {"dropped", share(wrong, dropped)},
          {"corrected", share(wrong, corrected)},
          {"kept_wrong", share(wrong, harmful)},
          {"good_dropped", share(good, dropped)}};
}

json json_masks(const MaskAccuracy& masks) {
  const auto ratio = [&](std::uint64_t all) -> json {
    if (all == 0) return nullptr;
    return static_cast<double>(masks.both) / static_cast<double>(all);
  };
  return {{"precision", ratio(masks.distrusted)}, {"recall", ratio(masks.hidden)}};
}

const char* word_for(const ViewAccuracy& view) {
  if (view.decision == Decision::outlier) return "outlier";
  return view.pose ? "stored" : "rejected";
}

json json_view(const ViewAccuracy& view) {
  json entry{{"name", view.name}, {"wrong", view.wrong}, {"decision", word_for(view)}};
  if (view.pose) {
    entry["pose_px"] = {{"given", json_number(view.pose->given_px)},
                        {"stored", json_number(view.pose->stored_px)},
                        {"relative", json_number(view.pose->relative_px)}};
    entry["gain_given"] = {view.given_gain.r, view.given_gain.g, view.given_gain.b};
    entry["gain_stored"] = {view.stored_gain.r, view.stored_gain.g, view.stored_gain.b};
  }
  if (view.refinement) {
    const Alignment& alignment = view.refinement->alignment;
    entry["refinement"] = {{"points", view.refinement->points},
                           {"views_per_point", view.refinement->views_per_point},
                           {"moved", alignment.moved},
                           {"moved_px", json_number(alignment.moved_px)},
                           {"residual_given", alignment.residual_given},
                           {"residual", alignment.residual},
                           {"correlation", alignment.correlation ? json(*alignment.correlation) : json()}};
  }
  return entry;
}

std::string number_text(const json& value, int decimals, double scale = 1) {
  if (!value.is_number()) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(decimals) << scale * value.get<double>();
  return text.str();
}

std::string percent_text(const json& share) {
  return number_text(share, 0, 100);
}

std::string spread_text(const json& spread) {
  return number_text(spread["median"], 2) + " / " + number_text(spread["p95"], 2);
}

}  // namespace

BuildOptions options_to_keep_all() {
  BuildOptions options;
  options.completion.far_sphere = false;
  options.max_views = 1u << 20;
  options.planner.min_view_gain = 0;
  options.texture_px.reset();
  return options;
}

RefinementAccuracy measure_refinement(const std::filesystem::path& scene, const BuildOptions& options) {
  const BuildResult built = build_model(scene, options);
  const Snapshot& snapshot = built.snapshot;
  const Truth truth = read_synthetic_truth(scene, snapshot.surface->offset);
  const std::unique_ptr<Visibility> visibility = make_ray_visibility(snapshot.surface->mesh);
  const std::map<std::string, Stored> stored = stored_views(snapshot);
  RefinementAccuracy result;
  std::vector<PosePair> pairs;
  std::vector<double> refine_ms;
  for (const PlannedView& planned : built.planned) {
    const TrueView& known = truth_of(truth, scene, planned.name);
    ViewAccuracy view{planned.name, known.wrong, planned.verdict.decision,  {},
                      known.gain,   known.gain,  planned.verdict.refinement};
    PosePair pair{known.camera, known.camera, {}};
    if (const auto found = stored.find(planned.name); found != stored.end()) {
      view.pose = PoseError{};
      view.stored_gain = known.gain * found->second.gain;
      pair.measured = found->second.view->camera;
      pair.points = points_seen(known.camera, *visibility);
      add_mask(*found->second.view, known, result.masks);
    }
    if (planned.verdict.refinement) refine_ms.push_back(planned.verdict.refine_ms);
    result.views.push_back(std::move(view));
    pairs.push_back(std::move(pair));
  }
  measure_poses(pairs, given_cameras(scene, snapshot.surface->offset), result.views);
  result.refine_ms = percentile(std::move(refine_ms), 0.5);
  return result;
}

json json_accuracy(const RefinementAccuracy& accuracy) {
  const std::vector<const ViewAccuracy*> stored = stored_good_views(accuracy);
  json views = json::array();
  for (const ViewAccuracy& view : accuracy.views) views.push_back(json_view(view));
  const auto worse = [](const ViewAccuracy* view) { return view->pose->stored_px > view->pose->given_px + kWorse_px; };
  const auto fine = [](const ViewAccuracy* view) { return view->pose->stored_px <= kFine_px; };
  const auto relatively_fine = [](const ViewAccuracy* view) { return view->pose->relative_px <= kFine_px; };
  return {{"offered", accuracy.views.size()},
          {"stored", stored.size()},
          {"pose_px",
           {{"given", json_spread(stored, &PoseError::given_px)},
            {"stored", json_spread(stored, &PoseError::stored_px)},
            {"relative", json_spread(stored, &PoseError::relative_px)},
            {"made_worse", share(stored, worse)},
            {"within_half", share(stored, fine)},
            {"within_half_relative", share(stored, relatively_fine)}}},
          {"exposure_ev",
           {{"given", exposure_error_ev(stored, &ViewAccuracy::given_gain)},
            {"stored", exposure_error_ev(stored, &ViewAccuracy::stored_gain)}}},
          {"wrong_poses", json_wrong_poses(accuracy)},
          {"masks", json_masks(accuracy.masks)},
          {"refine_ms", json_number(accuracy.refine_ms)},
          {"views", std::move(views)}};
}

std::string accuracy_table_head() {
  return "Pose errors in pixels, median / 95th percentile of the stored views; relative: less the views' common "
         "motion\n\n"
         "| scene | stored | given | stored poses | relative | made worse, % | within 0.5 px, % | relative, % "
         "| exposure, EV | wrong: dropped, corrected, kept, % | good dropped, % | masks: precision, recall, % | ms |\n"
         "|---|---|---|---|---|---|---|---|---|---|---|---|---|\n";
}

std::string accuracy_table_row(const std::string& scene, const json& accuracy) {
  const json& pose = accuracy["pose_px"];
  const json& wrong = accuracy["wrong_poses"];
  const json& exposure = accuracy["exposure_ev"];
  std::ostringstream row;
  row << "| " << scene << " | " << accuracy["stored"] << " of " << accuracy["offered"] << " | "
      << spread_text(pose["given"]) << " | " << spread_text(pose["stored"]) << " | " << spread_text(pose["relative"])
      << " | " << percent_text(pose["made_worse"]) << " | " << percent_text(pose["within_half"]) << " | "
      << percent_text(pose["within_half_relative"]) << " | " << number_text(exposure["given"], 3) << " -> "
      << number_text(exposure["stored"], 3) << " | " << percent_text(wrong["dropped"]) << ", "
      << percent_text(wrong["corrected"]) << ", " << percent_text(wrong["kept_wrong"]) << " | "
      << percent_text(wrong["good_dropped"]) << " | " << percent_text(accuracy["masks"]["precision"]) << ", "
      << percent_text(accuracy["masks"]["recall"]) << " | " << number_text(accuracy["refine_ms"], 0) << " |\n";
  return row.str();
}

}  // namespace lumatlas
