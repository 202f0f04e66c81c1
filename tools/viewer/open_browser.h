// SPDX-License-Identifier: GPL-3.0-or-later
// Opens an address with the desktop's program for it. That program prints nothing here, and may outlive this one, as
// browsers do. If there is none, nothing happens.
#pragma once

#include <string>

namespace lumatlas {

void open_browser(const std::string& address);

}  // namespace lumatlas
