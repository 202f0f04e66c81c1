// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/inspection/mesh_diagnosis.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>
#include <utility>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/requirement.h"
#include "mesh/repair/simplification.h"
#include "mesh/scene_extent.h"
#include "tools/inspection/mesh_shift.h"
#include "tools/scene/scene_points.h"

namespace lumatlas {

namespace {

using nlohmann::json;

constexpr Requirement diagnosis_requires{"mesh diagnosis"};

// Something that may have been done to the mesh or to the photographs.
struct Explanation {
  MeshFrame mesh;  // the change that the mesh needs
  PictureChange picture;
  std::string text;  // without the remedy where it is a change of the mesh
};

// ---- The mesh in other units or axes -----------------------------------------------------------------------------

struct Unit {
  double scale;
  const char* name;
};

// Factors by which a mesh may have to be multiplied, and how each comes about.
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
         (large ? "large" : "small") + unit.name;
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

constexpr const char* kYUp = "x,-z,y";  // turns a mesh that is y up to z up
constexpr const char* kZUp = "x,z,-y";
constexpr const char* kTurnedOver = "x,-y,-z";

std::string axes_text(const glm::dmat3& axes) {
  const std::string names = mesh_axes_text(axes);
  if (names == kYUp) return "the mesh is probably y up where the poses are z up";
  if (names == kZUp) return "the mesh is probably z up where the poses are y up";
  if (glm::determinant(axes) < 0) return "the mesh is probably mirrored";
  return "the mesh probably has other axes than the poses";
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
    if (axes != glm::dmat3(1.0)) list.push_back({{.axes = axes}, {}, axes_text(axes)});
  }
  for (const Unit& unit : kUnits) list.push_back({{.scale = unit.scale}, {}, scale_text(unit)});
  return list;
}

// Both at once, as modelling programs export: other units, and y up or the other way round.
std::vector<Explanation> combined_explanations() {
  std::vector<Explanation> list;
  for (const char* const names : {kYUp, kZUp, kTurnedOver}) {
    const glm::dmat3 axes = parse_mesh_axes(names);
    for (const Unit& unit : kUnits) {
      list.push_back(
          {{.axes = axes, .scale = unit.scale}, {}, scale_text(unit) + " and has other axes than the poses"});
    }
  }
  return list;
}

struct Explained {
  Explanation explanation;
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
    if (fit.correlation >= needed) best = {explanation, fit.correlation};
  }
  return best;
}

// ---- The mesh shifted -------------------------------------------------------------------------------------------

Mesh with_axes(Mesh mesh, const glm::dmat3& axes) {
  for (glm::vec3& position : mesh.positions) position = glm::vec3(axes * glm::dvec3(position));
  return mesh;
}

// Shifts under which the scene's points lie on the mesh, with the axes that modelling programs export, each if there is
// one. `mesh` lies around `offset`.
std::vector<Explanation> shift_explanations(const Mesh& mesh, const glm::dvec3& offset, const ScenePoints& points) {
  constexpr std::size_t kMostPoints = 20'000;
  const std::size_t stride = points.positions.size() / kMostPoints + 1;
  std::vector<Explanation> list;
  for (const char* const names : {"x,y,z", kYUp, kZUp}) {
    const glm::dmat3 axes = parse_mesh_axes(names);
    const glm::dvec3 mesh_origin = axes * offset;
    std::vector<glm::dvec3> around;
    for (std::size_t i = 0; i < points.positions.size(); i += stride) {
      around.push_back(points.positions[i] - mesh_origin);
    }
    const std::optional<glm::dvec3> shift = estimated_mesh_shift(with_axes(mesh, axes), around);
    if (!shift) continue;
    const std::string other_axes = axes == glm::dmat3(1.0) ? "" : " and has other axes than the poses";
    list.push_back({{.axes = axes, .shift = *shift}, {}, "the mesh is probably shifted" + other_axes});
  }
  return list;
}

// ---- What no change of units and axes explains -------------------------------------------------------------------

std::string whole_number(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", value < 10 ? 1 : 0, value);
  return text;
}

// Empty unless the mesh is far away from all cameras.
std::string far_away_text(const Mesh& mesh, const std::vector<SceneView>& views,
                          const std::vector<std::size_t>& ranks) {
  constexpr double kFarAway = 10;  // times the size of mesh and cameras together
  glm::dvec3 middle(0);
  for (const std::size_t rank : ranks) middle += views[rank].camera.center() / static_cast<double>(ranks.size());
  double extent = 0;
  for (const std::size_t rank : ranks) extent = std::max(extent, glm::distance(views[rank].camera.center(), middle));
  const double diameter = scene_diameter(mesh);
  if (!(glm::length(middle) > kFarAway * (diameter + 2 * extent))) return {};
  return "the mesh is " + whole_number(diameter) + " across and lies " + whole_number(glm::length(middle)) +
         " from the cameras: its coordinates are probably shifted, as those of a map are: give what takes them to "
         "those of the poses as --mesh-shift X,Y,Z, which is added; Metashape, RealityCapture and OpenDroneMap call it "
         "shift or offset, and name it in what they export";
}

// Returns nothing if there are no points or they cannot be read. Commands that need them report the fault.
std::optional<ScenePoints> points_of(const std::filesystem::path& scene) {
  try {
    return read_scene_points(scene, std::nullopt);
  } catch (const InputError&) {
    return std::nullopt;
  }
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

// The evidence by which mesh, photographs and points of a scene are compared.
struct Evidence {
  const SurfaceInput& facts;
  const Mesh& mesh;
  const glm::dvec3& offset;
  const std::optional<ScenePoints>& points;
  const MeshFitMeter& meter;
};

// Single changes of units and axes first, but a shift if it is better, because under a wrong one of these colours may
// agree a little; then both units and axes.
std::optional<Explained> best_explanation(const Evidence& evidence, bool points_fit, double needed,
                                          const MeshDiagnosisOptions& options) {
  constexpr double kBetter = 0.05;  // than what is simpler
  const auto best = [&](const std::vector<Explanation>& list, double least) {
    return best_of(list, evidence.meter, least, options.least_shared);
  };
  std::optional<Explained> simple = best(simple_explanations(), needed);
  if (points_fit) return simple;
  if (evidence.points) {
    auto shifted = best(shift_explanations(evidence.mesh, evidence.offset, *evidence.points),
                        simple ? simple->correlation + kBetter : needed);
    if (shifted) return shifted;
  }
  return simple ? simple : best(combined_explanations(), needed);
}

// Without the digits that sums of `size` do not have.
double without_noise(double sum, double size) {
  constexpr double kDigits = 1e12;
  const double per_unit = kDigits / std::pow(10, std::ceil(std::log10(size)));
  return std::round(sum * per_unit) / per_unit;
}

// The frame to give instead of the `given` one for a mesh that needs `change` too.
MeshFrame remedy_of(const MeshFrame& given, const MeshFrame& change) {
  MeshFrame remedy = combined(given, change);
  const glm::dvec3 moved = glm::abs(change.scale * (change.axes * given.shift)), added = glm::abs(change.shift);
  const double size = std::max({moved.x, moved.y, moved.z, added.x, added.y, added.z});
  for (int i = 0; size > 0 && i < 3; ++i) remedy.shift[i] = without_noise(remedy.shift[i], size);
  return remedy;
}

// Notes the explanation, and the options that undo it where it is one of the mesh.
void note(const Explained& best, const MeshFrame& given, MeshDiagnosis& result) {
  result.likely = best.explanation.text;
  result.likely_correlation = best.correlation;
  if (best.explanation.mesh == MeshFrame{}) return;
  result.remedy = remedy_of(given, best.explanation.mesh);
  result.likely += ": give " + mesh_frame_options(*result.remedy);
}

// Fills in what is likely. `result` has the other figures.
void explain(const Evidence& evidence, const std::vector<SceneView>& views, const std::vector<std::size_t>& ranks,
             const MeshDiagnosisOptions& options, MeshDiagnosis& result) {
  const double given = result.as_given.correlation;
  const bool by_chance = !(given > options.chance);
  const bool points_fit = result.points_on_mesh && *result.points_on_mesh >= options.least_points_on_mesh;
  const double needed = std::max(options.least_correlation, std::isnan(given) ? 0 : given + options.plainly_better);
  if (const auto best = best_explanation(evidence, points_fit, needed, options)) {
    note(*best, evidence.facts.frame, result);
    result.wrong_frame = result.remedy && by_chance && !points_fit;
  } else if (!points_fit) {
    result.likely = far_away_text(evidence.mesh, views, ranks);
    if (result.likely.empty() && given <= options.chance) {
      result.likely = "it is probably the mesh of another scene, or shifted or turned against the poses";
    }
  }
}

std::string misfit_sentence(const std::filesystem::path& mesh_file, const MeshDiagnosis& diagnosis,
                            const MeshDiagnosisOptions& options) {
  std::string sentence = mesh_file.string() + ": does not fit the photographs: " +
                         fit_text(diagnosis.as_given, diagnosis.points_on_mesh, options.least_correlation) + "; " +
                         diagnosis.likely;
  if (!diagnosis.likely_correlation) return sentence;
  char text[40];
  std::snprintf(text, sizeof(text), " (correlation then %.2f)", *diagnosis.likely_correlation);
  return sentence + text;
}

// Empty unless vertices lie in steps of more than half of what a pixel shows.
std::string coarse_coordinates_warning(const SurfaceInput& facts, const Mesh& mesh, const std::vector<SceneView>& views,
                                       const std::vector<std::size_t>& ranks) {
  std::vector<Camera> cameras;
  cameras.reserve(ranks.size());
  for (const std::size_t rank : ranks) cameras.push_back(views[rank].camera);
  const double pixel = pixel_size(mesh, cameras, 0.5);
  if (!(facts.coordinate_step > pixel / 2)) return {};
  return facts.mesh_file.string() + ": its coordinates come in steps of " + short_text(facts.coordinate_step) +
         ", as numbers of few digits do so far from 0, and a pixel of the photographs shows " + short_text(pixel) +
         ": the surface is rough by that; export it again in local coordinates, with an offset subtracted, and give "
         "the "
         "offset as --mesh-shift X,Y,Z, or with 64-bit numbers";
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

MeshDiagnosis diagnose_mesh(const std::filesystem::path& scene, const SurfaceInput& facts, const Mesh& mesh,
                            const glm::dvec3& offset, const Visibility& visibility, const std::vector<SceneView>& views,
                            const std::vector<std::size_t>& ranks, const MeshDiagnosisOptions& options) {
  check(options);
  MeshDiagnosis result;
  const std::string coarse = coarse_coordinates_warning(facts, mesh, views, ranks);
  if (!coarse.empty()) result.warnings.push_back(coarse);
  const MeshFitMeter meter(views, ranks, visibility, offset, options.fit);
  result.as_given = meter.measure();
  if (meter.black_border() >= options.least_border) {
    result.black_border = meter.black_border();
    result.warnings.push_back(border_warning(result.black_border));
  }
  if (result.as_given.correlation >= options.least_correlation || meter.pictures() < 2) return result;
  const std::optional<ScenePoints> points = points_of(scene);
  if (points) {
    const double share = meter.points_on_mesh(*points, options.same_place);
    if (!std::isnan(share)) result.points_on_mesh = share;
  }
  explain({facts, mesh, offset, points, meter}, views, ranks, options, result);
  if (result.likely.empty()) return result;
  result.misfit = misfit_sentence(facts.mesh_file, result, options);
  result.warnings.push_back(result.misfit);
  return result;
}

void require_right_frame(const MeshDiagnosis& diagnosis) {
  if (!diagnosis.wrong_frame) return;
  throw InputError(diagnosis.misfit + "; if it is right as it is, give --mesh-scale 1");
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
          {"likely", diagnosis.likely.empty() ? json() : json(diagnosis.likely)},
          {"remedy", diagnosis.remedy ? mesh_frame_json(*diagnosis.remedy) : json()}};
}

}  // namespace lumatlas
