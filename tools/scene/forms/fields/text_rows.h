// SPDX-License-Identifier: GPL-3.0-or-later
// Files of one record a line, as trajectories and calibrations are written.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace lumatlas {

struct TextRow {
  std::size_t line;                      // from 1
  std::vector<std::string_view> fields;  // at least one; of the text that was read
};

// The lines of `text` that are neither empty nor begin with '#', cut at blanks, or at every comma where `by_commas`:
// fields are then without blanks around them, and may be empty.
[[nodiscard]] std::vector<TextRow> rows_of(std::string_view text, bool by_commas = false);

// Throws InputError "PATH: line N: REASON".
[[noreturn]] void refuse_row(const std::filesystem::path& path, const TextRow& row, const std::string& reason);

// A field as a finite number. Throws InputError, also where there is no such field.
[[nodiscard]] double number_in(const TextRow& row, std::size_t field, const std::filesystem::path& path);

}  // namespace lumatlas
