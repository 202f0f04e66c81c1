// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/cli/output/print_address.h"

#include <iostream>
#include <nlohmann/json.hpp>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"
#include "tools/base/process/process_limits.h"
#include "tools/cli/output/json_output.h"

namespace lumatlas {

void print_address(const std::string& address, bool as_json) {
  if (as_json) {
    print_json({{"address", address}});
  } else {
    std::cout << address << '\n';
  }
  if (std::cout.flush()) return;
  throw_if_interrupted();
  throw InputError("the page's address cannot be written to standard output, " + why_not_written());
}

}  // namespace lumatlas
