// SPDX-License-Identifier: GPL-3.0-or-later
// The result of a validation: as a web page that works offline, and as JSON for scripts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/scene/scene.h"
#include "tools/score/measures/flicker.h"
#include "tools/score/measures/scores.h"

namespace lumatlas {

// The result of one method for one held-out view. Paths are relative to the page, with '/'; empty: no such picture.
struct ReportRendering {
  ViewScores scores;
  std::string picture;          // the frame as `lumatlas render` shows it
  std::string error;            // error_picture of the frame after its exposure gain
  std::string aligned_picture;  // the frame from the refined pose, after its exposure gain
  std::string aligned_error;    // error_picture of that
};

// The changes that the build made to one photograph, see planner/refinement/alignment.h.
struct ReportRefinement {
  std::string name;
  std::string decision;                                           // "kept", "replaced", "outlier"
  double residual_given = 0, residual_exposed = 0, residual = 0;  // sRGB, of [0, 1]
  double moved_px = 0;
  double exposure_ev = 0;
};

struct ReportView {
  std::string name;
  std::string photograph;   // see ReportRendering::picture
  std::uint32_t width = 0;  // its pictures', pixels
  std::uint32_t height = 0;
  std::vector<ReportRendering> renderings;  // one per method, in the order of Report::methods
};

struct ReportMethod {
  std::string name;                               // "store", "texture", "unbounded", "vertex"
  std::string description;                        // one line for the reader
  std::optional<double> seams = std::nullopt;     // SeamMeter::contrast() over all scored views, levels
  std::optional<Flicker> flicker = std::nullopt;  // along a path whose true pictures are known
};

// The difference of the unbounded baseline's mean fitted PSNR over the mesh's pixels and the store's, dB; either part
// may be below 0.
struct ReportShortfall {
  double moved = 0;   // because the poses of its photographs were refined, and those of the scored ones were not
  double budget = 0;  // the rest: fewer photographs, references and texels
};

struct Report {
  std::string title;  // the page's title: the scene's name
  std::optional<HoldOut> protocol =
      HoldOut();                              // which views were left out; none: those of the scene's own list, if any
  std::string test;                           // the workspace all of whose views are scored; empty: those left out
  std::size_t input_views = 0;                // that the methods learned from
  std::vector<ReportMethod> methods;          // the one to look at first comes first
  std::vector<ReportView> views;              // that were scored
  std::optional<ReportShortfall> shortfall;   // measured with the unbounded baseline alone
  std::vector<ReportRefinement> refinements;  // the views that the model was built from
  std::vector<std::pair<std::string, std::string>> facts;  // more to tell about the run: what, value
};

// Throws std::invalid_argument naming the view and the rule: renderings for all methods, paths that are relative.
void check(const Report& report);

// One sentence, or "" where there is nothing to tell: the store is not below the unbounded baseline.
[[nodiscard]] std::string shortfall_sentence(const Report& report);

// Each method's means over the views, in the order of Report::methods.
[[nodiscard]] std::vector<MethodScores> method_means(const Report& report);

// The whole page: the protocol, each method's means and the spread over views, and for every view photograph, rendering
// and error side by side, worst first by the fitted PSNR of the first method's frames. Sorts by other scores, switches
// between methods and compares pictures in place where scripts run; without them it shows everything. Loads nothing but
// the pictures.
[[nodiscard]] std::string report_page(const Report& report);

// report_page into a file, which appears complete or not at all. Throws InputError if it cannot be written.
void write_report(const std::filesystem::path& path, const Report& report);

// {"protocol": {"hold", "block", "test"}, "held": views, "methods": {NAME: MEANS}, "shortfall": {"moved", "budget"},
// "views": [{"name", "methods": {NAME: SCORES}}]} with MEANS = {"frame": REGION, REGION of the mesh's pixels, "seams",
// "flicker": {"rms", "worst", "followed"}} and REGION = "raw": {"psnr", "ssim"}, "fitted", "aligned", "textured".
// Absent are those that were not measured, and those of the protocol that do not apply. SCORES are MEANS without
// "seams" and "flicker", with "gain", "pixels" and "aligned_pixels" in either region. Numbers are as in json_number; an
// infinite PSNR is kPsnrOfIdentical.
[[nodiscard]] nlohmann::json report_json(const Report& report);

}  // namespace lumatlas
