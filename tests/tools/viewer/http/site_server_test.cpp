// SPDX-License-Identifier: GPL-3.0-or-later
// The server from outside: what it answers, and what it keeps to itself.
#include "tools/viewer/http/site_server.h"

#include <httplib.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "mesh/base/errors.h"
#include "tests/tools/viewer/http/raw_client.h"
#include "tools/viewer/http/files_together.h"
#include "tools/viewer/http/host_header.h"

namespace lumatlas {
namespace {

// A server with two files, while this lives.
class Running {
 public:
  explicit Running(const ServerOptions& options = {}) : server_(options) {
    server_.add({"index.html", "text/html", {'p', 'a', 'g', 'e'}});
    server_.add({"views/1.bin", "application/octet-stream", {1, 2, 3}});
    thread_ = std::thread([this] { server_.serve([this] { return stop_.load(); }); });
    const std::string address = server_.address();
    port_ = std::stoi(address.substr(address.rfind(':') + 1));
  }
  ~Running() {
    stop_ = true;
    thread_.join();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] std::string address() const { return server_.address(); }
  [[nodiscard]] std::vector<std::string> addresses_for_others() const { return server_.addresses_for_others(); }
  httplib::Result get(const std::string& path, const httplib::Headers& headers = {}) const {
    httplib::Client client("127.0.0.1", port_);
    return client.Get(path, headers);
  }

 private:
  SiteServer server_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
  int port_ = 0;
};

TEST_CASE("its files are served, and nothing else") {
  const Running server;
  const auto page = server.get("/");
  REQUIRE(page);
  CHECK(page->status == 200);
  CHECK(page->body == "page");
  CHECK(server.get("/index.html")->body == "page");
  CHECK(server.get("/views/1.bin")->body == std::string("\1\2\3"));
  for (const char* path : {"/etc/passwd", "/../../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd",
                           "/views/../../etc/passwd", "/views", "/index.html/", "/."}) {
    INFO(path);
    CHECK(server.get(path)->status == 404);
  }
}

// Returns 4 bytes, the least significant first.
std::string length_bytes(std::uint32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xFF));
  return bytes;
}

TEST_CASE("several files come in one answer, in the order in which they are asked for") {
  const Running server;
  const std::string one = length_bytes(3) + "\1\2\3";
  const std::string page = length_bytes(4) + "page";
  const std::string none = length_bytes(kNotTogether);
  CHECK(server.get("/together?views/1.bin&index.html")->body == one + page);
  CHECK(server.get("/together?index.html")->body == page);
  CHECK(server.get("/together?gone.bin&index.html&../etc/passwd&")->body == none + page + none);
  CHECK(server.get("/together?index.html&index.html")->body == page + none);
  CHECK(server.get("/together?&")->body == none);
  CHECK(server.get("/together")->status == 404);
  CHECK(server.get("/together?")->status == 404);
  CHECK(server.get("/index.html?views/1.bin")->body == "page");
}

TEST_CASE("files on a disk, and those that would make the answer too large, are not in one with others") {
  const auto file = [](std::size_t bytes, const std::string& path) {
    return std::make_shared<const SiteFile>(SiteFile{"file", "text/plain", std::vector<std::uint8_t>(bytes), path});
  };
  const FindSiteFile find = [&](const std::string& name) {
    if (name == "disk") return file(0, "/dev/null");
    return file(name == "half" || name == "other-half" ? kMostBytesTogether / 2 : 1, "");
  };
  const auto answer = [&](const char* query) {
    const std::vector<std::uint8_t> bytes = files_together(query, find);
    return std::string(bytes.begin(), bytes.end());
  };
  const std::string none = length_bytes(kNotTogether);
  const std::string half = length_bytes(kMostBytesTogether / 2) + std::string(kMostBytesTogether / 2, '\0');
  CHECK(answer("disk") == none);
  CHECK(answer("half&small&other-half") == half + length_bytes(1) + std::string(1, '\0') + none);
  CHECK(answer("half&other-half&small") == half + half + none);
}

TEST_CASE("pages of others can neither frame nor read it") {
  const Running server;
  const auto page = server.get("/");
  CHECK(page->get_header_value("X-Content-Type-Options") == "nosniff");
  CHECK(page->get_header_value("X-Frame-Options") == "DENY");
  CHECK(page->get_header_value("Content-Security-Policy").find("frame-ancestors 'none'") != std::string::npos);
  CHECK_FALSE(page->has_header("Access-Control-Allow-Origin"));
  const std::string port = std::to_string(server.port());
  CHECK(server.get("/", {{"Host", "evil.example:" + port}})->status == 403);
  CHECK(server.get("/", {{"Host", "localhost:" + port}})->status == 200);
}

TEST_CASE("a port that is taken is refused with the system's reason") {
  const Running server;
  ServerOptions options;
  options.port = server.port();
  CHECK_THROWS_WITH(SiteServer(options),
                    "127.0.0.1:" + std::to_string(server.port()) + ": cannot be listened at: Address already in use");
}

// The status of an answer to a client that knows the server by that name.
int status_by_name(int port, const std::string& host) {
  RawConnection connection(port, "127.0.0.2");
  connection.send("GET / HTTP/1.1\r\nHost: " + host + "\r\n\r\n");
  const auto answer = connection.read();
  return answer ? answer->status : 0;
}

TEST_CASE("at all addresses of this machine a name of another site is refused, and an address is not") {
  ServerOptions options;
  options.host = "0.0.0.0";
  const Running server(options);
  CHECK_THAT(server.address(), Catch::StartsWith("http://127.0.0.1:"));
  for (const std::string& other : server.addresses_for_others()) {
    CHECK_THAT(other, Catch::EndsWith(":" + std::to_string(server.port()) + "/"));
    CHECK_THAT(other, !Catch::Contains("//127.") && !Catch::Contains("//0."));
  }
  CHECK(Running().addresses_for_others().empty());
  CHECK(status_by_name(server.port(), "127.0.0.2:" + std::to_string(server.port())) == 200);
  CHECK(status_by_name(server.port(), "192.168.1.7:8080") == 200);
  CHECK(status_by_name(server.port(), "[fe80::1]") == 200);
  CHECK(status_by_name(server.port(), "localhost") == 200);
  CHECK(status_by_name(server.port(), "evil.example:" + std::to_string(server.port())) == 403);
  CHECK(status_by_name(server.port(), "0.0.0.0.evil.example") == 403);
}

TEST_CASE("only the name that the user gave is served, in whatever case, at whatever port") {
  CHECK(names_this_server("My-Machine.local:8080", "my-machine.local"));
  CHECK(names_this_server("my-machine.local", "my-machine.local"));
  CHECK_FALSE(names_this_server("my-machine.local.evil.example", "my-machine.local"));
  CHECK_FALSE(names_this_server("machine.local", "my-machine.local"));
  CHECK_FALSE(names_this_server("my-machine.local:80x", "my-machine.local"));
  CHECK_FALSE(names_this_server("", "my-machine.local"));
  CHECK_FALSE(names_this_server("", ""));
}

TEST_CASE("a host that cannot be listened at is refused with its name") {
  ServerOptions options;
  options.host = "";
  CHECK_THROWS_AS(SiteServer(options), std::invalid_argument);
  for (const char* host : {"no-such-host.invalid", "192.0.2.1", "[::1", "127.0.0.1:80", "/etc"}) {
    options.host = host;
    CHECK_THROWS_WITH(SiteServer(options), Catch::StartsWith(std::string(host) + ": cannot be listened at: "));
  }
}

TEST_CASE("what asks it to stop may throw") {
  SiteServer server(ServerOptions{});
  CHECK_THROWS_AS(server.serve([]() -> bool { throw InputError("enough"); }), InputError);
}

}  // namespace
}  // namespace lumatlas
