// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/viewer/http/raw_client.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <stdexcept>
#include <utility>

namespace lumatlas {

namespace {

using Clock = std::chrono::steady_clock;

[[noreturn]] void malformed(const std::string& what, const std::string& text) {
  throw std::runtime_error("not a well-formed answer: " + what + ": " + text.substr(0, 300));
}

bool is_token(std::string_view text) {
  return !text.empty() &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isalnum(c) != 0 || c == '-'; });
}

// The answer whose head this is, without the empty line at its end.
RawAnswer parsed_head(const std::string& head) {
  RawAnswer answer;
  std::size_t at = head.find("\r\n");
  const std::string first = head.substr(0, at);
  const bool has_status = first.size() > 12 && first.starts_with("HTTP/1.") && (first[7] == '0' || first[7] == '1') &&
                          first[8] == ' ' && first[12] == ' ';
  if (!has_status) malformed("status line", first);
  answer.status = std::stoi(first.substr(9, 3));
  if (answer.status < 200 || answer.status > 599) malformed("status", first);
  while (at != std::string::npos) {
    const std::size_t start = at + 2;
    at = head.find("\r\n", start);
    const std::string line = head.substr(start, at == std::string::npos ? at : at - start);
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos || !is_token(line.substr(0, colon))) malformed("header", line);
    if (line.find_first_of("\r\n") != std::string::npos) malformed("line break in a header", line);
    std::string name = line.substr(0, colon);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    if (!answer.headers.emplace(name, line.substr(colon + 2)).second) malformed("a header twice", line);
  }
  return answer;
}

}  // namespace

RawConnection::RawConnection(int port, const char* address)
    : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in there{};
  there.sin_family = AF_INET;
  there.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, address, &there.sin_addr);
  if (socket_ < 0 || connect(socket_, reinterpret_cast<const sockaddr*>(&there), sizeof there) != 0) {
    if (socket_ >= 0) close(socket_);
    throw std::runtime_error("no connection");
  }
}

RawConnection::~RawConnection() {
  if (socket_ >= 0) close(socket_);
}

RawConnection::RawConnection(RawConnection&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), unread_(std::move(other.unread_)) {}

bool RawConnection::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool RawConnection::receive(Clock::time_point until) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
  pollfd waiting{socket_, POLLIN, 0};
  if (poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(left, 0))) != 1) return false;
  std::array<char, 65536> buffer{};
  const ssize_t received = recv(socket_, buffer.data(), buffer.size(), 0);
  if (received <= 0) return false;
  unread_.append(buffer.data(), static_cast<std::size_t>(received));
  return true;
}

std::optional<RawAnswer> RawConnection::read(bool to_head, std::chrono::milliseconds time) {
  const auto until = Clock::now() + time;
  std::size_t end = std::string::npos;
  while ((end = unread_.find("\r\n\r\n")) == std::string::npos) {
    if (receive(until)) continue;
    if (unread_.empty()) return std::nullopt;
    malformed("the head breaks off", unread_);
  }
  RawAnswer answer = parsed_head(unread_.substr(0, end));
  unread_.erase(0, end + 4);
  const auto length = answer.headers.find("content-length");
  if (length == answer.headers.end()) malformed("no length", std::to_string(answer.status));
  if (length->second.empty() || length->second.find_first_not_of("0123456789") != std::string::npos ||
      length->second.size() > 12) {
    malformed("length", length->second);
  }
  if (to_head) return answer;
  const std::size_t size = std::stoull(length->second);
  while (unread_.size() < size) {
    if (!receive(until)) malformed("the body breaks off at " + std::to_string(unread_.size()), length->second);
  }
  answer.body = unread_.substr(0, size);
  unread_.erase(0, size);
  return answer;
}

bool RawConnection::is_closed_within(std::chrono::milliseconds time) {
  const auto until = Clock::now() + time;
  while (receive(until)) {
  }
  return Clock::now() < until;
}

void RawConnection::reset() {
  const linger at_once{1, 0};
  setsockopt(socket_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
  close(std::exchange(socket_, -1));
}

std::string get_request(const std::string& path, int port, const std::string& more_headers) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n" + more_headers + "\r\n";
}

}  // namespace lumatlas
