// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tools/base/output_folder.h"
#include "tools/pipeline/build_model.h"
#include "tools/pipeline/given_build_settings.h"
#include "tools/pipeline/model_budget.h"
#include "tools/pipeline/output/save_model.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/codings.h"
#include "tools/python/mesh_frames.h"
#include "tools/python/model.h"
#include "tools/python/names.h"
#include "tools/python/progress.h"
#include "tools/stereo/scene_stereo.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
// Python's True is an int as well: bool is tried first.
using Value = std::variant<bool, std::int64_t, double, std::string>;
using Faces = std::optional<std::variant<std::size_t, std::string>>;

constexpr std::array<std::pair<const char*, RefineMode>, 5> kRefineModes{{{"none", RefineMode::none},
                                                                          {"exposure", RefineMode::exposure},
                                                                          {"pose", RefineMode::pose},
                                                                          {"all", RefineMode::all},
                                                                          {"joint", RefineMode::joint}}};

// Returns the text of a value, as `lumatlas build --set` takes it.
std::string typed_text(const Value& value) {
  if (const bool* const is_on = std::get_if<bool>(&value)) return *is_on ? "on" : "off";
  if (const auto* const whole = std::get_if<std::int64_t>(&value)) return std::to_string(*whole);
  if (const auto* const number = std::get_if<double>(&value)) return setting_text(*number);
  return std::get<std::string>(value);
}

GivenBuildSettings settings_of(const std::map<std::string, Value>& given) {
  std::vector<Assignment> assignments;
  for (const auto& [name, value] : given) assignments.push_back({name, typed_text(value)});
  return GivenBuildSettings(std::move(assignments));
}

// A model that is bounded by a loss is chosen by a measure of its own, from which settings that were given depart.
void choose_by_given(const GivenBuildSettings& given, BuildOptions& options) {
  if (options.planner.coverage.metric != CoverageOptions::Metric::directions) {
    throw std::invalid_argument("loss: needs coverage.metric=directions");
  }
  if (options.choice != ViewChoice::online) throw std::invalid_argument("loss: needs stream.choice=online");
  given.choose_by_given(options.planner);
}

ModelBudget budget_of(std::optional<std::uint64_t> gpu_bytes, std::optional<std::uint64_t> texels,
                      std::optional<double> loss) {
  if ((gpu_bytes ? 1 : 0) + (texels ? 1 : 0) + (loss ? 1 : 0) > 1) {
    throw std::invalid_argument("gpu_bytes, texels and loss: more than one is given, name one bound");
  }
  if (gpu_bytes == 0u) throw std::invalid_argument("gpu_bytes is 0, must be at least 1");
  if (texels == 0u) throw std::invalid_argument("texels is 0, must be at least 1");
  ModelBudget budget;
  budget.gpu_bytes = gpu_bytes.value_or(0);
  budget.texels = texels.value_or(0);
  budget.automatic = loss.has_value();
  budget.loss_db = loss.value_or(budget.loss_db);
  return budget;
}

FaceOptions faces_of(const Faces& given, bool few) {
  FaceOptions faces;
  const std::string* const word = given ? std::get_if<std::string>(&*given) : nullptr;
  if (word != nullptr && *word != "auto" && *word != "keep") {
    throw std::invalid_argument("faces is '" + *word + "', must be a number, keep or auto");
  }
  if (given && word == nullptr) {
    faces.faces = std::get<std::size_t>(*given);
  } else if (word != nullptr ? *word == "auto" : few) {
    faces.pixels = kFacesPixels;
  }
  return faces;
}

void warn_of(const BuildResult& result) {
  for (const std::string& sentence : result.warnings) warn(sentence);
  for (const SkippedView& view : result.skipped) warn("left out: " + view.why);
}

std::shared_ptr<Model> build(const Scene& scene, const Path& output, const std::optional<Path>& mesh,
                             const std::optional<double>& mesh_scale, const std::optional<std::string>& mesh_axes,
                             const std::optional<std::array<double, 3>>& mesh_shift, bool mesh_as_given,
                             std::optional<std::size_t> hold, std::size_t block, std::optional<std::uint32_t> max_views,
                             std::optional<std::uint64_t> gpu_bytes, std::optional<std::uint64_t> texels,
                             std::optional<double> loss, std::optional<std::uint64_t> memory_bytes, const Faces& faces,
                             double cell_size, const std::string& refine, std::optional<std::uint32_t> texture,
                             const std::string& image, std::optional<int> quality,
                             const std::map<std::string, Value>& settings, const py::object& progress) {
  const GivenBuildSettings given = settings_of(settings);
  BuildOptions options;
  options.mesh = mesh;
  options.mesh_frame = mesh_frame_of(mesh_scale, mesh_axes, mesh_shift);
  options.pictures = scene.pictures;
  options.completion.surface = !mesh_as_given;
  options.completion.stereo_folder = stereo_folder_of(output);
  options.memory = {memory_bytes, scratch_folder_for(output)};
  options.hold_out = protocol_of(hold, block);
  options.cells.size = cell_size;
  if (max_views) options.max_views = max_views;
  options.tight_tiles = compressed_tiles(options.tiles);
  given.apply(options);
  const ModelBudget budget = budget_of(gpu_bytes, texels, loss);
  given.check_budget(budget, options);
  options.faces = faces_of(faces, wants_few_faces(budget, options.tiles));
  apply_budget(budget, max_views.has_value(), options);
  if (budget.automatic) choose_by_given(given, options);
  options.refine = value_named(kRefineModes, "refine", refine);
  given.check_refinement(options.refine);
  options.texture_px = texture;
  const ImageCoding coding = image_coding(image, quality);
  check(options);
  check_apart(output, std::array{scene.path, mesh.value_or(Path()), scene.pictures.images.value_or(Path()),
                                 scene.pictures.masks.value_or(Path())});
  const Progress told("build", progress);
  BuildResult result;
  {
    const py::gil_scoped_release unlocked;
    ModelOutput opened(output);
    result = build_model(scene.path, options, told.of_build());
    (void)save_model(result, opened, coding);
    remove_stereo_work(options.completion.stereo_folder);
  }
  warn_of(result);
  const py::gil_scoped_release unlocked;
  return open_model(output);
}

}  // namespace

void bind_build(py::module_& module) {
  module.def("build", &build, py::arg("scene"), py::arg("output"), py::kw_only(), py::arg("mesh") = py::none(),
             py::arg("mesh_scale") = py::none(), py::arg("mesh_axes") = py::none(), py::arg("mesh_shift") = py::none(),
             py::arg("mesh_as_given") = false, py::arg("hold") = py::none(), py::arg("block") = 1,
             py::arg("max_views") = py::none(), py::arg("gpu_bytes") = py::none(), py::arg("texels") = py::none(),
             py::arg("loss") = py::none(), py::arg("memory_bytes") = py::none(), py::arg("faces") = py::none(),
             py::arg("cell_size") = 0.0, py::arg("refine") = "joint", py::arg("texture") = BuildOptions{}.texture_px,
             py::arg("image") = "png", py::arg("quality") = py::none(), py::arg("settings") = py::dict(),
             py::arg("progress") = py::none(),
             "Choose photographs, save them as a model (a folder, or one .glb), and open it");
}

}  // namespace lumatlas::python
