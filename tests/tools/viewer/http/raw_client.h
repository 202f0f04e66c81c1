// SPDX-License-Identifier: GPL-3.0-or-later
// A client that sends any bytes to a server on this machine, in any pieces, and reads its answers strictly by
// RFC 9112: what no browser would send, and what no browser would forgive.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace lumatlas {

struct RawAnswer {
  int status = 0;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
};

class RawConnection {
 public:
  // Connects to the port at 127.0.0.1, or at another address of this machine. Throws std::runtime_error.
  explicit RawConnection(int port, const char* address = "127.0.0.1");
  ~RawConnection();
  RawConnection(RawConnection&& other) noexcept;
  RawConnection(const RawConnection&) = delete;
  RawConnection& operator=(const RawConnection&) = delete;

  // False: the server has closed the connection.
  bool send(std::string_view bytes);
  // The next answer. None: the connection ended, or stayed silent for so long, before the first byte of one. Throws
  // std::runtime_error for what is no whole, well-formed answer. `to_head`: without a body, however long it says that
  // it is.
  std::optional<RawAnswer> read(bool to_head = false, std::chrono::milliseconds time = std::chrono::seconds(20));
  // Returns whether the server closes the connection within that time; what it still sends is thrown away.
  bool is_closed_within(std::chrono::milliseconds time);
  // Closes with a reset: what is on its way is lost.
  void reset();

 private:
  // False: the end, or the time is over.
  bool receive(std::chrono::steady_clock::time_point until);

  int socket_ = -1;
  std::string unread_;
};

// The request of a browser for a file.
[[nodiscard]] std::string get_request(const std::string& path, int port, const std::string& more_headers = "");

}  // namespace lumatlas
