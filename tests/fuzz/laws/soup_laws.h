// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of a mesh reader for any bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "mesh/base/errors.h"
#include "mesh/mesh.h"
#include "tests/fuzz/laws/sentence_laws.h"

namespace lumatlas {

template <typename Parse>
void check_soup_laws(Parse parse, const std::uint8_t* data, std::size_t size) {
  try {
    const TriangleSoup soup = parse(std::string_view(reinterpret_cast<const char*>(data), size), std::string("name"));
    require(!soup.faces.empty());
    require(soup.colors.empty() || soup.colors.size() == soup.positions.size());
    for (const glm::uvec3& face : soup.faces) {
      for (int corner = 0; corner < 3; ++corner) require(face[corner] < soup.positions.size());
    }
    require(24 * soup.positions.capacity() + 12 * soup.faces.capacity() <= 64 + 48 * size);
  } catch (const InputError& error) {
    const std::string_view sentence = error.what();
    require(sentence.starts_with("name: ") && sentence.size() < 300);
    require(sentence.find_first_of("\r\n") == std::string_view::npos);
  }
}

}  // namespace lumatlas
