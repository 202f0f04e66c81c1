// SPDX-License-Identifier: GPL-3.0-or-later
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/base/output_folder.h"
#include "tools/python/bindings.h"

namespace lumatlas::python {

namespace py = pybind11;

py::object to_python(const nlohmann::json& value) {
  return py::module_::import("json").attr("loads")(json_text(value));
}

std::optional<HoldOut> protocol_of(std::optional<std::size_t> hold, std::size_t block) {
  if (!hold) {
    if (block != 1) throw std::invalid_argument("block is " + std::to_string(block) + ", but hold is None: give both");
    return std::nullopt;
  }
  const HoldOut protocol{*hold, block};
  check(protocol);
  return protocol;
}

}  // namespace lumatlas::python

PYBIND11_MODULE(_lumatlas, module) {
  module.doc() = "View-dependent textured scenes from a mesh and posed photographs";
  module.attr("__version__") = LUMATLAS_VERSION;
  lumatlas::python::bind_camera(module);
  lumatlas::python::bind_scene(module);
  lumatlas::python::bind_model(module);
  lumatlas::python::bind_build(module);
}
