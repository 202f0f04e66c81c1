// SPDX-License-Identifier: GPL-3.0-or-later
// Checks whether a request's Host header names this server. A page of another site can be led to this address by its
// owner (DNS rebinding), and then sends that site's name. So only names that the user of the server knows are accepted.
#pragma once

#include <string>
#include <string_view>

namespace lumatlas {

// `header`: NAME or NAME:PORT. Returns true for "localhost", for `given`, the name or address that the user has the
// server listen at, and for any IP address, because it is not looked up and so cannot be led elsewhere. (A router may
// translate addresses.) The port is ignored: browsers leave 80 out, and a tunnel has another one.
[[nodiscard]] bool names_this_server(std::string_view header, const std::string& given);

}  // namespace lumatlas
