// SPDX-License-Identifier: GPL-3.0-or-later
// The server from outside: what it answers, and what it keeps to itself.
#include "tools/viewer/site_server.h"

#include <httplib.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <string>
#include <thread>

#include "mesh/base/errors.h"

namespace lumatlas {
namespace {

// A server with two files, while this lives.
class Running {
 public:
  Running() {
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
  httplib::Result get(const std::string& path, const httplib::Headers& headers = {}) const {
    httplib::Client client("127.0.0.1", port_);
    return client.Get(path.c_str(), headers);
  }

 private:
  SiteServer server_{ServerOptions{}};
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

TEST_CASE("a port that is taken is refused") {
  const Running server;
  ServerOptions options;
  options.port = server.port();
  CHECK_THROWS_AS(SiteServer(options), InputError);
}

TEST_CASE("what asks it to stop may throw") {
  SiteServer server(ServerOptions{});
  CHECK_THROWS_AS(server.serve([]() -> bool { throw InputError("enough"); }), InputError);
}

}  // namespace
}  // namespace lumatlas
