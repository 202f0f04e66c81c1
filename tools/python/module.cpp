// SPDX-License-Identifier: GPL-3.0-or-later
#include <exception>
#include <filesystem>
#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>

#include "blend/gl/egl_context.h"
#include "mesh/base/errors.h"
#include "tools/base/error_sentence.h"
#include "tools/base/output_folder.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/progress.h"

namespace lumatlas::python {

namespace py = pybind11;

py::object to_python(const nlohmann::json& value) {
  return py::module_::import("json").attr("loads")(json_text(value));
}

void warn(const std::string& sentence) {
  if (PyErr_WarnEx(PyExc_UserWarning, sentence.c_str(), 1) != 0) throw py::error_already_set();
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

// The module's exceptions, which live as long as the process.
struct Exceptions {
  py::handle error, input_error, gl_error, stopped;
};
Exceptions exceptions;

py::handle made_exception(py::module_& module, const char* name, py::handle base, const char* doc) {
  const std::string full_name = "lumatlas." + std::string(name);
  const py::handle made(PyErr_NewExceptionWithDoc(full_name.c_str(), doc, base.ptr(), nullptr));
  if (!made) throw py::error_already_set();
  module.attr(name) = made;
  return made;
}

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
  } catch (const InputError& error) {
    raise(exceptions.input_error.ptr(), error);
  } catch (const std::filesystem::filesystem_error& error) {
    raise(exceptions.input_error.ptr(), error);
  } catch (const GlError& error) {
    raise(exceptions.gl_error.ptr(), error);
  } catch (const Stopped& error) {
    raise(exceptions.stopped.ptr(), error);
  } catch (const std::exception& error) {
    raise(exceptions.error.ptr(), error);
  }
}

}  // namespace

void bind_exceptions(py::module_& module) {
  exceptions.error = made_exception(module, "Error", PyExc_RuntimeError, "What fails, in the program's sentence");
  exceptions.input_error =
      made_exception(module, "InputError", exceptions.error, "A file, a folder or another program that cannot be used");
  exceptions.gl_error = made_exception(module, "GlError", exceptions.error, "OpenGL cannot be used");
  exceptions.stopped = made_exception(module, "Stopped", exceptions.error, "`progress` has returned False");
  py::register_exception_translator(&tell_in_sentences);
}

}  // namespace lumatlas::python

PYBIND11_MODULE(_lumatlas, module) {
  module.doc() = "View-dependent textured scenes from a mesh and posed photographs";
  module.attr("__version__") = LUMATLAS_VERSION;
  lumatlas::python::bind_exceptions(module);
  lumatlas::python::bind_camera(module);
  lumatlas::python::bind_scene(module);
  lumatlas::python::bind_model(module);
  lumatlas::python::bind_render(module);
  lumatlas::python::bind_capture(module);
  lumatlas::python::bind_mesh(module);
  lumatlas::python::bind_build(module);
  lumatlas::python::bind_validate(module);
  lumatlas::python::bind_export(module);
  lumatlas::python::bind_inspect(module);
}
