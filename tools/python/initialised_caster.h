// SPDX-License-Identifier: GPL-3.0-or-later
// Objects that Python made without __init__ (`Camera.__new__(Camera)`, copy.copy) hold no value. pybind11 would pass
// uninitialised memory to functions. A type whose caster is this one refuses such objects instead.
#pragma once

#include <pybind11/pybind11.h>

#include <string>

namespace lumatlas::python {

template <typename Value>
class InitialisedCaster : public pybind11::detail::type_caster_base<Value> {
 public:
  // Throws pybind11::type_error, which becomes TypeError, for an object of the type that holds no value.
  bool load(pybind11::handle source, bool convert) {
    const pybind11::detail::type_info* const type = pybind11::detail::get_type_info(typeid(Value));
    if (source && type != nullptr && PyObject_TypeCheck(source.ptr(), type->type) != 0) {
      auto* const instance = reinterpret_cast<pybind11::detail::instance*>(source.ptr());
      if (instance->get_value_and_holder(type, false).value_ptr() == nullptr) {
        throw pybind11::type_error(std::string(type->type->tp_name) +
                                   ": this object was made without __init__ and holds nothing");
      }
    }
    return pybind11::detail::type_caster_base<Value>::load(source, convert);
  }
};

}  // namespace lumatlas::python
