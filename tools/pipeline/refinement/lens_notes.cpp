// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/pipeline/refinement/lens_notes.h"

#include <cmath>
#include <functional>
#include <stdexcept>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

using nlohmann::json;

json correction_json(const LensCorrection& c) {
  return {{"focal", c.focal}, {"principal", {c.principal.x, c.principal.y}}, {"k1", c.k1}, {"k2", c.k2}, {"p1", c.p1},
          {"p2", c.p2}};
}

LensCorrection correction_from(const json& value) {
  LensCorrection correction{value.at("focal"), {value.at("principal").at(0), value.at("principal").at(1)},
                            value.at("k1"),    value.at("k2"),
                            value.at("p1"),    value.at("p2")};
  check(correction);
  return correction;
}

ShutterMotion motion_from(const json& value) {
  ShutterMotion motion{{value.at(0), value.at(1), value.at(2)}, {value.at(3), value.at(4), value.at(5)}};
  check(motion);
  return motion;
}

json camera_json(const Camera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

Camera camera_from(const json& value) {
  Camera camera;
  camera.width = value.at("width");
  camera.height = value.at("height");
  camera.fx = value.at("fx");
  camera.fy = value.at("fy");
  camera.cx = value.at("cx");
  camera.cy = value.at("cy");
  check(camera);
  return camera;
}

void correct(std::vector<SceneView>& views, const Camera& camera, const LensCorrection& correction) {
  for (SceneView& view : views) {
    if (share_a_lens(view.camera, camera)) view.correction = correction;
  }
}

// "+0.25" for 0.25 and 2 decimals.
std::string signed_text(double value, int decimals) {
  return (value < 0 ? "" : "+") + number_text(value, decimals);
}

// Names the parts of a correction that move a corner by a tenth of a pixel or more.
std::string terms_text(const LensCorrection& c, const Camera& camera) {
  constexpr double kWorthSaying = 0.1;
  std::string text;
  const auto add = [&](const LensCorrection& alone, const std::string& term) {
    if (corner_move_px(alone, camera) < kWorthSaying) return;
    text += (text.empty() ? "" : ", ") + term;
  };
  LensCorrection alone;
  alone.focal = c.focal;
  add(alone, "focal length " + signed_text(100 * (c.focal - 1), 2) + " %");
  alone = {};
  alone.principal = c.principal;
  add(alone, "principal point (" + signed_text(c.principal.x * camera.width, 1) + ", " +
                 signed_text(c.principal.y * camera.width, 1) + ") px");
  for (const auto& [field, name] : {std::pair(&LensCorrection::k1, "k1 "), std::pair(&LensCorrection::k2, "k2 "),
                                    std::pair(&LensCorrection::p1, "p1 "), std::pair(&LensCorrection::p2, "p2 ")}) {
    alone = {};
    alone.*field = c.*field;
    add(alone, name + number_text(c.*field, 4));
  }
  return text;
}

// Names what was estimated and not applied, without parts below half a pixel, which noise causes.
std::string left_as_given(const RefinedLens& lens) {
  constexpr double kWorthTelling = 0.5;
  const std::string terms = terms_text(lens.estimate.correction, lens.camera);
  if (terms.empty() || lens.estimate.corner_px < kWorthTelling) return {};
  return "lens: left as given; " + terms + " was estimated, which would move a corner by " +
         number_text(lens.estimate.corner_px, 1) + " px, but lowers the residual too little to be certain\n";
}

bool found_black_borders(const ModelNotes& notes) {
  const json::json_pointer where("/summary/fit/black_border");
  if (!notes.plan.contains(where)) return false;
  const json& share = notes.plan.at(where);
  return share.is_number() && share.get<double>() > 0;
}

}  // namespace

json shutters_json(const std::optional<RefinedShutters>& shutters) {
  if (!shutters) return {};
  const ShutterEstimate& estimate = shutters->estimate;
  json motions = json::object();
  for (const auto& [name, motion] : shutters->motions) {
    motions[name] = {motion.turn.x, motion.turn.y, motion.turn.z, motion.shift.x, motion.shift.y, motion.shift.z};
  }
  return {{"views", estimate.views},
          {"points", estimate.points},
          {"residual", {{"before", estimate.residual.before}, {"after", estimate.residual.after}}},
          {"median_px", shutters->median_px},
          {"applied", shutters->applied},
          {"motions", std::move(motions)}};
}

std::string shutters_text(const std::optional<RefinedShutters>& shutters) {
  if (!shutters || !shutters->applied) return {};
  return "rolling shutter: while it read a photograph, the camera moved the picture by " +
         number_text(shutters->median_px, 1) + " px in the median; " + std::to_string(shutters->motions.size()) +
         " photographs straightened\n";
}

void leave_out_black_rims(std::vector<SceneView>& views) {
  for (SceneView& view : views) view.black_rim = true;
}

json lenses_json(std::span<const RefinedLens> lenses) {
  json list = json::array();
  for (const RefinedLens& lens : lenses) {
    list.push_back({{"camera", camera_json(lens.camera)},
                    {"views", lens.views},
                    {"correction", correction_json(lens.estimate.correction)},
                    {"deviation", correction_json(lens.estimate.deviation)},
                    {"residual", {{"before", lens.estimate.residual.before}, {"after", lens.estimate.residual.after}}},
                    {"corner_px", lens.estimate.corner_px},
                    {"applied", lens.applied}});
  }
  return list;
}

std::string lenses_text(std::span<const RefinedLens> lenses) {
  std::string text;
  for (const RefinedLens& lens : lenses) {
    if (!lens.applied) {
      text += left_as_given(lens);
      continue;
    }
    text += "lens: " + terms_text(lens.estimate.correction, lens.camera) + ", a corner moves " +
            number_text(lens.estimate.corner_px, 1) + " px; " + std::to_string(lens.views) +
            " photographs undistorted again\n";
  }
  return text;
}

void correct_lenses(std::vector<SceneView>& views, std::span<const RefinedLens> lenses) {
  for (const RefinedLens& lens : lenses) {
    if (lens.applied) correct(views, lens.camera, lens.estimate.correction);
  }
}

namespace {

void correct_lenses_by(const json& lenses, std::vector<SceneView>& views) {
  if (!lenses.is_array()) throw std::invalid_argument("a list is missing");
  for (const json& lens : lenses) {
    if (!lens.at("applied").get<bool>()) continue;
    correct(views, camera_from(lens.at("camera")), correction_from(lens.at("correction")));
  }
}

// Calls `correct` with what the notes have at a place.
void correct_by_notes(const char* where, const ModelNotes& notes, const std::filesystem::path& model,
                      const std::function<void(const json& noted)>& correct) {
  const json::json_pointer place(where);
  if (!notes.plan.contains(place)) return;
  try {
    correct(notes.plan.at(place));
  } catch (const json::exception& error) {
    throw InputError(model.string() + ": its notes on lenses or shutters cannot be read (" + error.what() +
                     "): build the model again");
  } catch (const std::invalid_argument& error) {
    throw InputError(model.string() + ": its notes on lenses or shutters have impossible values (" + error.what() +
                     "): build the model again");
  }
}

void straighten_by(const json& shutters, std::vector<SceneView>& views) {
  if (shutters.is_null() || !shutters.at("applied").get<bool>()) return;
  const json& motions = shutters.at("motions");
  if (!motions.is_object()) throw std::invalid_argument("motions are missing");
  for (SceneView& view : views) {
    const auto found = motions.find(view.name);
    if (found != motions.end()) view.motion = motion_from(*found);
  }
}

}  // namespace

void correct_lenses(std::vector<SceneView>& views, const ModelNotes& notes, const std::filesystem::path& model) {
  if (found_black_borders(notes)) leave_out_black_rims(views);
  correct_by_notes("/summary/lenses", notes, model, [&](const json& lenses) { correct_lenses_by(lenses, views); });
}

void correct_photographs(std::vector<SceneView>& views, const ModelNotes& notes, const std::filesystem::path& model) {
  correct_lenses(views, notes, model);
  correct_by_notes("/summary/shutters", notes, model, [&](const json& shutters) { straighten_by(shutters, views); });
}

}  // namespace lumatlas
