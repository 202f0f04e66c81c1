// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/output/json_output.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/process/process_limits.h"

namespace lumatlas {

namespace {

void require_printed(const std::filesystem::path& output) {
  if (std::cout.flush()) return;
  throw_if_interrupted();  // by SIGPIPE: the reader of stdout has gone
  throw InputError(output.string() + ": is complete, but the result cannot be written to standard output, " +
                   why_not_written());
}

}  // namespace

void print_json(const nlohmann::json& result) {
  nlohmann::ordered_json versioned;
  versioned["lumatlas"] = LUMATLAS_VERSION;
  for (const auto& [key, value] : result.items()) versioned[key] = value;
  std::cout << versioned.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n';
}

void print_result(const nlohmann::json& result, const std::filesystem::path& output) {
  print_json(result);
  require_printed(output);
}

void print_result(const std::string& text, const std::filesystem::path& output) {
  std::cout << text;
  require_printed(output);
}

}  // namespace lumatlas
