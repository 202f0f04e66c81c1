// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "tools/base/output_folder.h"
#include "tools/capture/capture.h"
#include "tools/capture/capture_json.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/mesh_sources.h"
#include "tools/python/names.h"
#include "tools/python/progress.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;

constexpr std::array<std::pair<const char*, Matching>, 4> kMatchings{{{"automatic", Matching::automatic},
                                                                      {"exhaustive", Matching::exhaustive},
                                                                      {"sequential", Matching::sequential},
                                                                      {"spatial", Matching::spatial}}};
constexpr std::array<std::pair<const char*, Mapper>, 2> kMappers{
    {{"incremental", Mapper::incremental}, {"global", Mapper::global}}};

py::object capture_photographs(const Path& photographs, const Path& output, const std::optional<Path>& work,
                               const std::optional<Path>& masks, std::size_t max_frames, const std::string& matching,
                               const std::optional<Path>& vocabulary, const std::string& camera_model,
                               const std::string& mapper, const std::optional<Path>& poses, bool use_gpu,
                               const std::optional<std::string>& source, const std::optional<Path>& points,
                               std::optional<std::size_t> hold, std::size_t block,
                               std::optional<std::uint32_t> max_views, const py::object& progress) {
  CaptureOptions options;
  options.most_frames = max_frames;
  options.colmap.matching = {value_named(kMatchings, "matching", matching), vocabulary};
  options.colmap.camera_model = camera_model;
  options.colmap.mapper = value_named(kMappers, "mapper", mapper);
  options.poses = poses;
  options.colmap.use_gpu = use_gpu;
  options.masks = masks;
  if (source) options.mesh.from = mesh_source(*source);
  options.mesh.points = points;
  options.build.hold_out = protocol_of(hold, block);
  if (max_views) options.build.max_views = max_views;
  check(options);
  const Path made_in = work.value_or(capture_beside(output));
  check_apart(output, std::array{photographs, made_in, masks.value_or(Path()), points.value_or(Path()),
                                 poses.value_or(Path()), vocabulary.value_or(Path())});
  const Progress told("capture", progress);
  nlohmann::json facts;
  {
    const py::gil_scoped_release unlocked;
    const CaptureListener listener{{}, told.of_stages(), told.of_build()};
    facts = capture_json(capture(photographs, made_in, output, options, listener), made_in, output);
  }
  return to_python(facts);
}

}  // namespace

void bind_capture(py::module_& module) {
  module.def("capture", &capture_photographs, py::arg("photographs"), py::arg("output"), py::kw_only(),
             py::arg("work") = py::none(), py::arg("masks") = py::none(),
             py::arg("max_frames") = CaptureOptions().most_frames, py::arg("matching") = "automatic",
             py::arg("vocabulary") = py::none(), py::arg("camera_model") = ColmapOptions().camera_model,
             py::arg("mapper") = "incremental", py::arg("poses") = py::none(), py::arg("use_gpu") = false,
             py::arg("source") = py::none(), py::arg("points") = py::none(), py::arg("hold") = py::none(),
             py::arg("block") = 1, py::arg("max_views") = py::none(), py::arg("progress") = py::none(),
             "From a folder of photographs and videos, or one video, to a model, with COLMAP's poses; returns what "
             "`lumatlas capture --json` "
             "prints");
}

}  // namespace lumatlas::python
