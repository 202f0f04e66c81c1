// SPDX-License-Identifier: GPL-3.0-or-later
#include <exception>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "tools/base/error_sentence.h"
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

namespace {

// Sentences name files, whose names may hold bytes that are not UTF-8: these are told as "\xff". Python would make an
// empty text of the whole sentence.
void raise(PyObject* kind, const std::exception& error) {
  const std::string sentence = error_sentence(error);
  const auto text = py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(sentence.data(), static_cast<py::ssize_t>(sentence.size()), "backslashreplace"));
  if (text) PyErr_SetObject(kind, text.ptr());
}

// The kinds that pybind11 knows keep their Python type, and their sentence where they have one of ours.
void tell_in_sentences(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const py::error_already_set&) {
    throw;
  } catch (const py::builtin_exception&) {
    throw;
  } catch (const std::invalid_argument& error) {
    raise(PyExc_ValueError, error);
  } catch (const std::logic_error&) {
    throw;
  } catch (const std::bad_alloc& error) {
    raise(PyExc_MemoryError, error);
  } catch (const std::exception& error) {
    raise(PyExc_RuntimeError, error);
  }
}

}  // namespace

void bind_exceptions() {
  py::register_exception_translator(&tell_in_sentences);
}

}  // namespace lumatlas::python

PYBIND11_MODULE(_lumatlas, module) {
  module.doc() = "View-dependent textured scenes from a mesh and posed photographs";
  module.attr("__version__") = LUMATLAS_VERSION;
  lumatlas::python::bind_exceptions();
  lumatlas::python::bind_camera(module);
  lumatlas::python::bind_scene(module);
  lumatlas::python::bind_model(module);
  lumatlas::python::bind_build(module);
}
