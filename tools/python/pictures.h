// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures as NumPy arrays that own their pixels, without a copy.
#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"

namespace lumatlas::python {

// `shape`: rows, columns and what else a pixel has. Needs Python's lock.
template <typename Value>
[[nodiscard]] pybind11::array_t<Value> array_of(std::vector<Value> values, std::vector<pybind11::ssize_t> shape) {
  auto kept = std::make_unique<std::vector<Value>>(std::move(values));
  Value* const data = kept->data();
  const pybind11::capsule owner(kept.get(), [](void* given) { delete static_cast<std::vector<Value>*>(given); });
  (void)kept.release();
  return pybind11::array_t<Value>(std::move(shape), data, owner);
}

[[nodiscard]] inline pybind11::array_t<std::uint8_t> picture_array(Photograph picture) {
  const auto height = static_cast<pybind11::ssize_t>(picture.height);
  const auto width = static_cast<pybind11::ssize_t>(picture.width);
  return array_of(std::move(picture.rgb), {height, width, 3});
}

}  // namespace lumatlas::python
