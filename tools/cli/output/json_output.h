// SPDX-License-Identifier: GPL-3.0-or-later
// Prints the result of a command on stdout, as text or as JSON. tools/cli/README.md lists the keys.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace lumatlas {

// Prints an object with the program's version as its first key, "lumatlas". Bytes that are not UTF-8 become U+FFFD.
void print_json(const nlohmann::json& result);

// Print the result of a command whose output is in place at `output`, and wait until stdout has it. The output stays
// where stdout cannot take the result: then they throw InputError, whose sentence says so; Interrupted where the reader
// of a pipe has gone.
void print_result(const nlohmann::json& result, const std::filesystem::path& output);
void print_result(const std::string& text, const std::filesystem::path& output);

}  // namespace lumatlas
