// SPDX-License-Identifier: GPL-3.0-or-later
// Laws of a reader's refusal of any input.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>

#include "mesh/base/errors.h"

namespace lumatlas {

inline void require(bool law) {
  if (!law) std::abort();
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

// In the current folder, which tests/fuzz/run makes for the program.
inline void write_input(const std::string& name, std::string_view bytes) {
  std::ofstream(name, std::ios::binary) << bytes;
}

// Only an InputError may leave `read`, and its sentence is one line.
template <typename Read>
void check_refusal(Read read) {
  try {
    read();
  } catch (const InputError& error) {
    const std::string_view sentence = error.what();
    require(!sentence.empty() && sentence.size() < 2000);
    require(sentence.find_first_of("\r\n") == std::string_view::npos);
  }
}

}  // namespace lumatlas
