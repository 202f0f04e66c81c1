// SPDX-License-Identifier: GPL-3.0-or-later
// What the desktop opens addresses with. It says nothing here, and may outlive this program, as browsers do; where
// there is none, nothing happens.
#pragma once

#include <string>

namespace lumatlas {

void open_browser(const std::string& address);

}  // namespace lumatlas
