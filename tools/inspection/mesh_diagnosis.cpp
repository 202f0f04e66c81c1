// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/mesh_diagnosis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/requirement.h"
#include "mesh/scene_extent.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr Requirement diagnosis_requires{"mesh diagnosis"};

// Something that may have been done to the mesh or to the photographs.
struct Explanation {
  MeshChange mesh;
  PictureChange picture;
  std::string text;
};

// ---- The mesh in other units or axes -----------------------------------------------------------------------------

struct Unit {
  double scale;
  const char* name;
};

// What a mesh has to be multiplied by, and how that comes about.
constexpr Unit kUnits[] = {{1e-3, ", as in millimetres for metres"},
                           {1e3, ", as in metres for millimetres"},
                           {1e-2, ", as in centimetres for metres"},
                           {1e2, ", as in metres for centimetres"},
                           {0.1, ""},
                           {10, ""},
                           {0.0254, ", as in inches for metres"},
                           {1 / 0.0254, ", as in metres for inches"},
                           {0.3048, ", as in feet for metres"},
                           {1 / 0.3048, ", as in metres for feet"}};

std::string short_text(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", value);
  return text;
}

std::string scale_text(const Unit& unit) {
  const bool large = unit.scale < 1;
  return "the mesh is probably " + short_text(large ? 1 / unit.scale : unit.scale) + " times too " +
         (large ? "large" : "small") + unit.name + ": scale it by " + short_text(unit.scale);
}

std::vector<glm::dmat3> all_axes() {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  std::vector<glm::dmat3> all;
  for (const auto& order : kOrders) {
    for (int signs = 0; signs < 8; ++signs) {
      glm::dmat3 axes(0.0);
      for (int i = 0; i < 3; ++i) axes[order[i]][i] = (signs >> i & 1) != 0 ? -1 : 1;
      all.push_back(axes);
    }
  }
  return all;
}

// The world's x, y and z in terms of the mesh's: "(x, -z, y)".
std::string axes_names(const glm::dmat3& axes) {
  std::string text = "(";
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      if (axes[column][row] == 0) continue;
      text += row == 0 ? "" : ", ";
      text += axes[column][row] < 0 ? "-" : "";
      text += "xyz"[column];
    }
  }
  return text + ")";
}

std::string axes_text(const glm::dmat3& axes) {
  const std::string names = axes_names(axes);
  const std::string remedy = ": make (x, y, z) of it " + names;
  if (names == "(x, -z, y)") return "the mesh is probably y up where the poses are z up" + remedy;
  if (names == "(x, z, -y)") return "the mesh is probably z up where the poses are y up" + remedy;
  if (glm::determinant(axes) < 0) return "the mesh is probably mirrored" + remedy;
  return "the mesh probably has other axes than the poses" + remedy;
}

std::vector<Explanation> simple_explanations() {
  std::vector<Explanation> list;
  const auto add = [&](const PictureChange& change, const std::string& verb, const std::string& how) {
    list.push_back({{},
                    change,
                    "the photographs were probably " + verb + "ed" + how + " after their poses were found: " + verb +
                        " them back"});
  };
  add({1, false}, "turn", " by 90 degrees to the right");
  add({2, false}, "turn", " by 180 degrees");
  add({3, false}, "turn", " by 90 degrees to the left");
  add({0, true}, "mirror", "");
  for (const glm::dmat3& axes : all_axes()) {
    if (axes != glm::dmat3(1.0)) list.push_back({{axes, 1}, {}, axes_text(axes)});
  }
  for (const Unit& unit : kUnits) list.push_back({{glm::dmat3(1.0), unit.scale}, {}, scale_text(unit)});
  return list;
}

// Both at once, as modelling programs export: other units, and y up or the other way round.
std::vector<Explanation> combined_explanations() {
  std::vector<Explanation> list;
  for (const glm::dmat3& axes : all_axes()) {
    const std::string names = axes_names(axes);
    if (names != "(x, -z, y)" && names != "(x, z, -y)" && names != "(x, -y, -z)") continue;
    for (const Unit& unit : kUnits) {
      list.push_back({{axes, unit.scale}, {}, scale_text(unit) + ", and make (x, y, z) of it " + names});
    }
  }
  return list;
}

struct Explained {
  std::string text;
  double correlation = 0;
};

// Returns the explanation under which the colours agree best; none if they agree well enough under none.
std::optional<Explained> best_of(const std::vector<Explanation>& list, const MeshFitMeter& meter,
                                 double least_correlation, double least_shared) {
  std::optional<Explained> best;
  for (const Explanation& explanation : list) {
    const MeshFit fit = meter.measure(explanation.mesh, explanation.picture);
    if (static_cast<double>(fit.pairs) < least_shared * static_cast<double>(meter.pictures())) continue;
    const double needed = best ? best->correlation : least_correlation;
    if (fit.correlation >= needed) best = {explanation.text, fit.correlation};
  }
  return best;
}

// ---- What no change of units and axes explains -------------------------------------------------------------------

std::string whole_number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", value < 10 ? 1 : 0, value);
  return text;
}

// Empty unless the mesh is far away from all cameras.
std::string shift_text(const Mesh& mesh, const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks) {
  constexpr double kFarAway = 10;  // times the size of mesh and cameras together
  glm::dvec3 middle(0);
  for (const std::size_t rank : ranks) middle += views[rank].camera.center() / static_cast<double>(ranks.size());
  double extent = 0;
  for (const std::size_t rank : ranks) extent = std::max(extent, glm::distance(views[rank].camera.center(), middle));
  const double diameter = scene_diameter(mesh);
  if (!(glm::length(middle) > kFarAway * (diameter + 2 * extent))) return {};
  return "the mesh is " + whole_number(diameter) + " across and lies " + whole_number(glm::length(middle)) +
         " from the cameras: its coordinates are probably shifted, as those of a map are; subtract the shift";
}

std::optional<double> share_on_mesh(const std::filesystem::path& scene, const MeshFitMeter& meter, double same_place) {
  try {
    const double share = meter.points_on_mesh(read_scene_points(scene, std::nullopt), same_place);
    if (!std::isnan(share)) return share;
  } catch (const InputError&) {
    // A scene need not have points. Commands that need them say what is wrong with them.
  }
  return std::nullopt;
}

std::string fit_text(const MeshFit& fit, const std::optional<double>& points_on_mesh, double least_correlation) {
  if (fit.pairs == 0) return "no two of its photographs show the same part of it";
  char text[300];
  std::snprintf(text, sizeof(text),
                "colours of the same points in different photographs agree little better than by chance (correlation "
                "%.2f, %.2f or more where they fit; residual %.3f, %.0f%% outliers",
                fit.correlation, least_correlation, fit.residual, 100 * fit.outliers);
  std::string sentence = text;
  if (points_on_mesh) {
    std::snprintf(text, sizeof(text), "; %.0f%% of the scene's points lie on it", 100 * *points_on_mesh);
    sentence += text;
  }
  return sentence + ")";
}

std::string border_warning(double share) {
  char text[300];
  std::snprintf(text, sizeof(text),
                "the photographs have a black border, the same in all of them, as undistortion leaves it: %.1f%% of "
                "the pixels; a build leaves it out, as a mask would",
                100 * share);
  return text;
}

// Fills in what is likely. `result` has the other figures.
void explain(const MeshFitMeter& meter, const Mesh& mesh, const std::vector<SceneView>& views,
             const std::vector<std::size_t>& ranks, const MeshDiagnosisOptions& options, MeshDiagnosis& result) {
  const double given = result.as_given.correlation;
  const bool points_fit = result.points_on_mesh && *result.points_on_mesh >= options.least_points_on_mesh;
  const double needed = std::max(options.least_correlation, std::isnan(given) ? 0 : given + options.plainly_better);
  std::optional<Explained> best = best_of(simple_explanations(), meter, needed, options.least_shared);
  if (!best && !points_fit) best = best_of(combined_explanations(), meter, needed, options.least_shared);
  if (best) {
    result.likely = best->text;
    result.likely_correlation = best->correlation;
  } else if (!points_fit) {
    result.likely = shift_text(mesh, views, ranks);
    if (result.likely.empty() && given <= options.chance) {
      result.likely = "it is probably the mesh of another scene, or shifted or turned against the poses";
    }
  }
}

std::string misfit_warning(const std::filesystem::path& mesh_file, const MeshDiagnosis& diagnosis,
                           const MeshDiagnosisOptions& options) {
  std::string sentence = mesh_file.string() + ": does not fit the photographs: " +
                         fit_text(diagnosis.as_given, diagnosis.points_on_mesh, options.least_correlation) + "; " +
                         diagnosis.likely;
  if (!diagnosis.likely_correlation) return sentence;
  char text[40];
  std::snprintf(text, sizeof(text), " (correlation then %.2f)", *diagnosis.likely_correlation);
  return sentence + text;
}

json or_null(double value) {
  return std::isfinite(value) ? json(value) : json();
}

}  // namespace

void check(const MeshDiagnosisOptions& options) {
  check(options.fit);
  const auto in_unit = [](double value, const char* name) {
    diagnosis_requires(value > 0 && value < 1, name, value, "in (0, 1)");
  };
  in_unit(options.least_correlation, "least_correlation");
  in_unit(options.chance, "chance");
  in_unit(options.plainly_better, "plainly_better");
  in_unit(options.least_points_on_mesh, "least_points_on_mesh");
  in_unit(options.same_place, "same_place");
  in_unit(options.least_border, "least_border");
  diagnosis_requires(std::isfinite(options.least_shared) && options.least_shared >= 1, "least_shared",
                     options.least_shared, "finite and at least 1");
}

MeshDiagnosis diagnose_mesh(const std::filesystem::path& scene, const std::filesystem::path& mesh_file,
                            const Mesh& mesh, const glm::dvec3& offset, const Visibility& visibility,
                            const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
                            const MeshDiagnosisOptions& options) {
  check(options);
  MeshDiagnosis result;
  const MeshFitMeter meter(views, ranks, visibility, offset, options.fit);
  result.as_given = meter.measure();
  if (meter.black_border() >= options.least_border) {
    result.black_border = meter.black_border();
    result.warnings.push_back(border_warning(result.black_border));
  }
  if (result.as_given.correlation >= options.least_correlation || meter.pictures() < 2) return result;
  result.points_on_mesh = share_on_mesh(scene, meter, options.same_place);
  explain(meter, mesh, views, ranks, options, result);
  if (!result.likely.empty()) result.warnings.push_back(misfit_warning(mesh_file, result, options));
  return result;
}

json mesh_diagnosis_json(const MeshDiagnosis& diagnosis) {
  const MeshFit& fit = diagnosis.as_given;
  return {{"correlation", or_null(fit.correlation)},
          {"residual", or_null(fit.residual)},
          {"outliers", or_null(fit.outliers)},
          {"pairs", fit.pairs},
          {"points", fit.points},
          {"points_on_mesh", diagnosis.points_on_mesh ? json(*diagnosis.points_on_mesh) : json()},
          {"black_border", diagnosis.black_border},
          {"likely", diagnosis.likely.empty() ? json() : json(diagnosis.likely)}};
}

}  // namespace lumatlas
