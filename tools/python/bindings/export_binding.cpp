// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/base/output_folder.h"
#include "tools/export/export_model.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/codings.h"
#include "tools/python/model.h"
#include "tools/python/names.h"
#include "tools/python/progress.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;

PageCoding page_coding(const std::string& image, std::optional<int> quality) {
  PageCoding coding{value_named(kPageFormatsByName, "image", image == "jpg" ? "jpeg" : image)};
  if (quality && coding.format == PageFormat::png) {
    throw std::invalid_argument("quality is " + std::to_string(*quality) + ", but image is png, which is exact");
  }
  coding.quality = quality.value_or(coding.quality);
  return coding;
}

// Throws std::invalid_argument for an argument that a page would ignore.
void check_used_by_page(const std::vector<std::pair<const char*, bool>>& arguments) {
  for (const auto& [name, given] : arguments) {
    if (given) throw std::invalid_argument(std::string(name) + " is for textured meshes, and the form is web");
  }
}

py::object export_as(const Model& model, const Path& output, const std::string& form,
                     const std::optional<std::string>& image, std::optional<int> quality, bool as_scene,
                     std::optional<std::uint32_t> texture, std::optional<std::uint32_t> pages,
                     std::optional<double> density, const std::optional<std::string>& exposure, const Scene* scene,
                     const py::object& progress) {
  ExportOptions options;
  options.form = value_named(kExportFormsByName, "form", form);
  if (options.form == ExportForm::web) {
    check_used_by_page({{"as_scene", as_scene},
                        {"texture", texture.has_value()},
                        {"pages", pages.has_value()},
                        {"density", density.has_value()},
                        {"exposure", exposure.has_value()},
                        {"scene", scene != nullptr}});
    const int usual = options.photographs.quality;
    options.photographs = image_coding(image.value_or("jpeg"), quality);
    if (!quality) options.photographs.quality = usual;
  } else {
    options.image = page_coding(image.value_or("png"), quality);
    options.as_scene = as_scene;
    options.texture.layout.most_side_px = texture.value_or(options.texture.layout.most_side_px);
    options.texture.layout.most_pages = pages.value_or(options.texture.layout.most_pages);
    options.texture.texels_per_pixel = density.value_or(options.texture.texels_per_pixel);
    if (exposure) options.texture.color.exposure = value_named(kTextureExposuresByName, "exposure", *exposure);
    if (scene != nullptr) options.scene = scene->path;
    if (scene != nullptr) options.pictures = scene->pictures;
  }
  check(options, output);
  check_apart(output, std::array{model.path(), options.scene.value_or(Path())});
  const Progress told("export", progress);
  nlohmann::json facts;
  {
    const py::gil_scoped_release unlocked;
    facts = export_model(model.model(), model.path(), output, options, told.of_stages());
  }
  return to_python(facts);
}

}  // namespace

void bind_export(py::module_& module) {
  module.def("export", &export_as, py::arg("model"), py::arg("output"), py::kw_only(), py::arg("form") = "glb",
             py::arg("image") = py::none(), py::arg("quality") = py::none(), py::arg("as_scene") = false,
             py::arg("texture") = py::none(), py::arg("pages") = py::none(), py::arg("density") = py::none(),
             py::arg("exposure") = py::none(), py::arg("scene") = py::none(), py::arg("progress") = py::none(),
             "Write a model as a textured mesh for other programs (form glb, gltf or obj), or as a page for browsers "
             "(web); returns what `lumatlas export --json` prints");
}

}  // namespace lumatlas::python
