// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/text_rows.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "mesh/base/errors.h"
#include "mesh/base/text_fields.h"

namespace lumatlas {

namespace {

std::string_view without_blanks(std::string_view field) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  field.remove_prefix(std::min(field.find_first_not_of(kBlanks), field.size()));
  return field.substr(0, field.find_last_not_of(kBlanks) + 1);
}

std::vector<std::string_view> fields_between_commas(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(without_blanks(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

std::vector<TextRow> rows_of(std::string_view text, bool by_commas) {
  std::vector<TextRow> rows;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = without_blanks(take_line(text));
    if (line.empty() || line.starts_with('#')) continue;
    TextRow row{number, {}};
    if (by_commas) row.fields = fields_between_commas(line);
    while (!by_commas && !line.empty()) {
      const std::string_view field = take_field(line);
      if (!field.empty()) row.fields.push_back(field);
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

void refuse_row(const std::filesystem::path& path, const TextRow& row, const std::string& reason) {
  throw InputError(path.string() + ": line " + std::to_string(row.line) + ": " + reason);
}

double number_in(const TextRow& row, std::size_t field, const std::filesystem::path& path) {
  if (field >= row.fields.size()) {
    refuse_row(
        path, row,
        "has " + std::to_string(row.fields.size()) + " values, must have " + std::to_string(field + 1) + " or more");
  }
  const std::optional<double> number = parse_number(row.fields[field]);
  if (!number || !std::isfinite(*number)) {
    refuse_row(path, row, "has the value " + in_quotes(row.fields[field]) + ", which is not a finite number");
  }
  return *number;
}

}  // namespace lumatlas
