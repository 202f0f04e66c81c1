// SPDX-License-Identifier: GPL-3.0-or-later
// The server under attack: whatever is sent to it, each answer is well-formed, each byte of a body is the file's byte
// at that offset, and the next client is answered at once.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/tools/viewer/http/raw_client.h"
#include "tools/viewer/http/site_server.h"

namespace lumatlas {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// The time in which a whole request is answered, whatever others do; a sanitized server on a busy machine needs it.
constexpr seconds kAtOnce{2};

// Bytes that say where they are: no two places of a file are alike for long.
std::string placed_bytes(std::size_t size, unsigned seed) {
  std::mt19937 random(seed);
  std::string bytes(size, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random() & 0xff);
  return bytes;
}

// A server with files of many sizes, while this lives.
class Attacked {
 public:
  Attacked() {
    files_["/"] = files_["/index.html"] = placed_bytes(700, 1);
    files_["/none.bin"] = "";
    files_["/one.bin"] = "x";
    files_["/views/00001.jpg"] = placed_bytes(16384, 2);
    files_["/mesh.bin"] = placed_bytes(300001, 3);
    static const std::string large = placed_bytes(12000000, 4);
    files_["/large.bin"] = large;
    for (const auto& [path, bytes] : files_) {
      if (path != "/") server_.add({path.substr(1), "application/octet-stream", {bytes.begin(), bytes.end()}});
    }
    const std::string address = server_.address();
    port_ = std::stoi(address.substr(address.rfind(':') + 1));
    thread_ = std::thread([this] { server_.serve([this] { return stop_.load(); }); });
  }
  ~Attacked() {
    stop_ = true;
    thread_.join();
  }
  Attacked(const Attacked&) = delete;
  Attacked& operator=(const Attacked&) = delete;

  [[nodiscard]] int port() const { return port_; }
  [[nodiscard]] const std::map<std::string, std::string>& files() const { return files_; }

  // Checks that the answer to a request for that path, with any range, is one that the file allows.
  void check_answer(const std::string& path, const RawAnswer& answer) const {
    CAPTURE(path, answer.status, answer.body.size());
    const std::string& file = files_.at(path);
    const auto content_range = answer.headers.find("content-range");
    if (answer.status == 200) {
      CHECK(answer.body == file);
      CHECK(content_range == answer.headers.end());
    } else if (answer.status == 206) {
      REQUIRE(content_range != answer.headers.end());
      unsigned long long first = 0, last = 0, size = 0;
      REQUIRE(std::sscanf(content_range->second.c_str(), "bytes %llu-%llu/%llu", &first, &last, &size) == 3);
      CHECK(size == file.size());
      CHECK(first <= last);
      REQUIRE(last < file.size());
      CHECK(answer.body == file.substr(first, last - first + 1));
    } else {
      REQUIRE(answer.status == 416);
      REQUIRE(content_range != answer.headers.end());
      CHECK(content_range->second == "bytes */" + std::to_string(file.size()));
      CHECK(answer.body.size() < 200);
    }
  }

  // The next client gets the whole page at once.
  void check_alive() const {
    const auto start = std::chrono::steady_clock::now();
    RawConnection next(port_);
    REQUIRE(next.send(get_request("/", port_)));
    const auto answer = next.read(false, kAtOnce);
    REQUIRE(answer);
    CHECK(answer->status == 200);
    CHECK(answer->body == files_.at("/"));
    CHECK(std::chrono::steady_clock::now() - start < kAtOnce);
  }

 private:
  SiteServer server_{ServerOptions{}};
  std::map<std::string, std::string> files_;  // by the path that asks for them
  std::atomic<bool> stop_ = false;
  std::thread thread_;
  int port_ = 0;
};

// Ends of ranges around what may go wrong: the file's size, and the limits of whole numbers.
std::vector<std::string> range_ends(std::size_t size) {
  std::vector<std::string> ends{"",
                                "0",
                                "1",
                                "2",
                                "99999",
                                "2147483647",
                                "2147483648",
                                "4294967295",
                                "4294967296",
                                "9223372036854775807",
                                "9223372036854775808",
                                "18446744073709551614",
                                "18446744073709551615",
                                "18446744073709551616",
                                "99999999999999999999999999999999"};
  for (const std::size_t near : {size - 1, size, size + 1, size / 2}) ends.push_back(std::to_string(near));
  return ends;
}

std::vector<std::string> odd_ranges() {
  std::string many = "bytes=0-0", spread = "bytes=0-0", suffixes = "bytes=-1";
  for (int i = 1; i < 900; ++i) {
    many += ",0-0";
    spread += "," + std::to_string(4 * i) + "-" + std::to_string(4 * i);
    suffixes += ",-1";
  }
  return {many,
          suffixes,
          spread.substr(0, spread.rfind(',', 7000)),
          "bytes=",
          "bytes=-",
          "bytes",
          "",
          "=",
          "bytes=,",
          "bytes=,,,0-1",
          "bytes=0-1,",
          "bytes= 0-1",
          "bytes=0 - 1",
          "bytes=0-1 ",
          "BYTES=0-1",
          "bytes=a-b",
          "bytes=0-1-2",
          "bytes=--1",
          "bytes=+0-1",
          "bytes=0x0-0x1",
          "bytes=5-1",
          "bytes=0-0,5-1",
          "bytes=5-1,0-0",
          "bytes=0-0,99999999999-",
          "bytes=99999999999-,88888888888-",
          "bytes=%30-%31",
          "items=0-1",
          "bytes=0-1;q=1",
          "bytes=1-\t2",
          "bytes=\"0-1\"",
          "lines=1-2, bytes=0-1",
          std::string(3000, '0'),
          "bytes=" + std::string(3000, '0') + "-" + std::string(3000, '1'),
          "bytes=-" + std::string(3000, '9')};
}

TEST_CASE("ranges of all kinds give bytes of the file and nothing else") {
  const Attacked server;
  for (const auto& [path, file] : server.files()) {
    std::vector<std::string> ranges = odd_ranges();
    for (const std::string& first : range_ends(file.size())) {
      for (const std::string& last : range_ends(file.size())) ranges.push_back("bytes=" + first + "-" + last);
    }
    // Whole answers of large files say nothing that those of others do not.
    if (file.size() > 1000000)
      ranges = {"bytes=11999990-", "bytes=-7", "bytes=12000000-", "bytes=5-1", "bytes=0-0,1-1"};
    for (const std::string& range : ranges) {
      INFO(range.substr(0, 100));
      RawConnection connection(server.port());
      REQUIRE(connection.send(get_request(path, server.port(), "Range: " + range + "\r\n")));
      const auto answer = connection.read();
      REQUIRE(answer);
      server.check_answer(path, *answer);
    }
  }
  server.check_alive();
}

TEST_CASE("ranges are answered as RFC 9110 says") {
  const Attacked server;
  const std::string size = "300001";
  struct Asked {
    std::string range;  // value of the header, and what follows it
    int status;
    std::string content_range;
  };
  std::vector<Asked> all{
      {"bytes=0-99", 206, "bytes 0-99/" + size},
      {"bytes=0-999999", 206, "bytes 0-300000/" + size},
      {"bytes=300000-", 206, "bytes 300000-300000/" + size},
      {"bytes=-5", 206, "bytes 299996-300000/" + size},
      {"bytes=-99999999999999999999999", 206, "bytes 0-300000/" + size},
      {"bytes=7-18446744073709551616", 206, "bytes 7-300000/" + size},
  };
  for (const char* none : {"bytes=300001-", "bytes=18446744073709551616-18446744073709551617", "bytes=-0", "bytes=9-8",
                           "bytes=x", "bytes=300001-,400000-400001"}) {
    all.push_back({none, 416, "bytes */" + size});
  }
  // Several at once may be ignored, as must be other units and conditions that do not hold.
  for (const char* ignored :
       {"bytes=0-1,4-5", "pages=1-2", "bytes=0-1\r\nIf-Range: \"tag\"", "bytes=0-1\r\nRange: bytes=4-5"}) {
    all.push_back({ignored, 200, ""});
  }
  for (const Asked& asked : all) {
    INFO(asked.range);
    RawConnection connection(server.port());
    REQUIRE(connection.send(get_request("/mesh.bin", server.port(), "Range: " + asked.range + "\r\n")));
    const auto answer = connection.read();
    REQUIRE(answer);
    CHECK(answer->status == asked.status);
    const auto content_range = answer->headers.find("content-range");
    CHECK((content_range == answer->headers.end() ? "" : content_range->second) == asked.content_range);
    server.check_answer("/mesh.bin", *answer);
  }
  // HEAD has no ranges, and no body.
  RawConnection connection(server.port());
  REQUIRE(connection.send("HEAD /mesh.bin HTTP/1.1\r\nHost: localhost\r\nRange: bytes=0-1\r\n\r\n"));
  const auto head = connection.read(true);
  REQUIRE(head);
  CHECK(head->status == 200);
  CHECK(head->headers.at("content-length") == size);
  // The next answer on the connection begins where a body would.
  REQUIRE(connection.send(get_request("/one.bin", server.port())));
  const auto next = connection.read();
  REQUIRE(next);
  CHECK(next->body == "x");
}

TEST_CASE("only this machine's addresses and the name that was given are served") {
  const Attacked server;
  const std::string port = std::to_string(server.port());
  const std::vector<std::pair<std::string, int>> hosts{
      {"Host: localhost:" + port, 200},
      {"Host: LocalHost", 200},
      {"Host: 127.0.0.1", 200},
      {"Host: 127.0.0.1:" + port, 200},
      {"Host: 127.0.0.1:", 200},
      {"Host: [::1]:" + port, 200},
      {"Host: [::1]", 200},
      {"Host: 192.168.1.7:8080", 200},
      {"Host: evil.example:" + port, 403},
      {"Host: evil.example", 403},
      {"Host: localhost.evil.example", 403},
      {"Host: 127.0.0.1.evil.example:" + port, 403},
      {"Host: 127.0.0.1@evil.example", 403},
      {"Host: evil.example#127.0.0.1", 403},
      {"Host: 127.0.0.1:" + port + "x", 403},
      {"Host: [::1", 403},
      {"Host: [evil.example]", 403},
      {"Host: []", 403},
      {"Host: 127.0.0.1, evil.example", 403},
      {"Host: :" + port, 403},
      {"Host:", 403},
      {"Host: " + std::string(5000, 'a'), 403},
      {"X: y", 400},
      {"Host: localhost\r\nHost: evil.example", 400},
  };
  for (const auto& [header, status] : hosts) {
    INFO(header.substr(0, 100));
    RawConnection connection(server.port());
    REQUIRE(connection.send("GET / HTTP/1.1\r\n" + header + "\r\n\r\n"));
    const auto answer = connection.read();
    REQUIRE(answer);
    CHECK(answer->status == status);
    if (status != 200) CHECK(answer->body.size() < 300);
  }
  server.check_alive();
}

TEST_CASE("what is no request for a file gets a short refusal") {
  const Attacked server;
  const std::string host = "Host: localhost\r\n";
  std::vector<std::string> requests;
  for (const char* method :
       {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "PATCH", "CONNECT", "PRI", "BREW", "get", "G"}) {
    requests.push_back(std::string(method) + " / HTTP/1.1\r\n" + host + "\r\n");
    // Lengths that lie: the body is shorter, longer, or no length at all.
    for (const char* length : {"0", "3", "5", "-1", "18446744073709551615", "18446744073709551616", "1e3", ""}) {
      requests.push_back(std::string(method) + " / HTTP/1.1\r\n" + host + "Content-Length: " + length + "\r\n\r\nabc");
    }
    requests.push_back(std::string(method) + " / HTTP/1.1\r\n" + host +
                       "Transfer-Encoding: chunked\r\n\r\nffffffffffffffff\r\n");
  }
  for (const char* line : {"GET", "GET /", "GET / HTTP/9.9", "GET / HTTP/1.1 x", "GET  / HTTP/1.1", " GET / HTTP/1.1",
                           "/", "GET http://127.0.0.1/ HTTP/1.1", "GET * HTTP/1.1", "GET \\ HTTP/1.1", "GET / http/1.1",
                           "\x16\x03\x01\x02", "GET / HTTP/1.1\x01"}) {
    requests.push_back(std::string(line) + "\r\n" + host + "\r\n");
  }
  requests.push_back("GET /" + std::string(100000, 'a') + " HTTP/1.1\r\n" + host + "\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "X: " + std::string(100000, 'a') + "\r\n\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + std::string(100000, 'a') + "\r\n\r\n");
  std::string many = "GET / HTTP/1.1\r\n" + host;
  for (int i = 0; i < 20000; ++i) many += "X: y\r\n";
  requests.push_back(many + "\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "X\r\n\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "X : y\r\n\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "X: a\nY: b\r\n\r\n");
  requests.push_back(std::string("GET /\0 HTTP/1.1\r\n", 17) + host + "\r\n");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "Content-Length: 4\r\n\r\nabcd");
  requests.push_back("GET / HTTP/1.1\r\n" + host + "Content-Length: 3\r\nContent-Length: 4\r\n\r\nabcd");
  requests.emplace_back(200000, '\r');
  requests.emplace_back(200000, 'z');
  for (const std::string& request : requests) {
    INFO(request.substr(0, 120));
    RawConnection connection(server.port());
    connection.send(request);
    const auto answer = connection.read(false, seconds(5));
    REQUIRE(answer);
    CHECK(answer->status >= 400);
    CHECK(answer->status < 500);
    CHECK(answer->body.size() < 300);
    // The rest belongs to no request that the server understands.
    CHECK(connection.is_closed_within(seconds(5)));
  }
  server.check_alive();
}

TEST_CASE("names of files lead nowhere else") {
  const Attacked server;
  for (const char* path : {"/etc/passwd", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/.",
                           "/views", "/views/", "/index.html/", "/index.html%00", "/%", "/%zz", "/%c0%ae%c0%ae/"}) {
    INFO(path);
    RawConnection connection(server.port());
    REQUIRE(connection.send(get_request(path, server.port())));
    const auto answer = connection.read();
    REQUIRE(answer);
    CHECK((answer->status == 404 || answer->status == 400));
  }
  RawConnection connection(server.port());
  REQUIRE(connection.send(get_request("/?memory=1000", server.port())));
  CHECK(connection.read()->body == server.files().at("/"));
}

TEST_CASE("requests damaged by chance do no damage") {
  const Attacked server;
  const std::string whole = get_request("/views/00001.jpg", server.port(), "Range: bytes=5-16000\r\nAccept: */*\r\n");
  std::mt19937 random(7);
  for (int round = 0; round < 1500; ++round) {
    std::string request = whole;
    for (std::uint32_t i = 0, changes = 1 + random() % 4; i < changes; ++i) {
      const std::size_t at = random() % request.size();
      switch (random() % 4) {
        case 0:
          request[at] = static_cast<char>(random() & 0xff);
          break;
        case 1:
          request.erase(at, 1 + random() % 8);
          break;
        case 2:
          request.insert(at, request.substr(random() % request.size(), random() % 40));
          break;
        default:
          request.insert(at, std::to_string(random()));
          break;
      }
    }
    INFO("round " << round);
    RawConnection connection(server.port());
    connection.send(request + "\r\n\r\n");
    const auto answer = connection.read(request.starts_with("HEAD"), seconds(5));
    if (!answer || answer->status >= 400) continue;  // the damage may name another file, or none
    REQUIRE(request.find("/views/00001.jpg") != std::string::npos);
    server.check_answer("/views/00001.jpg", *answer);
  }
  server.check_alive();
}

TEST_CASE("no client waits for one that sends half a request") {
  const Attacked server;
  std::vector<RawConnection> halves;
  const std::string whole = get_request("/mesh.bin", server.port());
  for (std::size_t i = 0; i < 60; ++i) {
    halves.emplace_back(server.port());
    REQUIRE(halves.back().send(whole.substr(0, i % (whole.size() - 1))));
  }
  for (int i = 0; i < 5; ++i) server.check_alive();
  // Each byte that comes buys no time for the others either.
  for (RawConnection& half : halves) half.send("x");
  server.check_alive();
}

TEST_CASE("no client waits for one that does not read its answer") {
  const Attacked server;
  std::vector<RawConnection> deaf;
  for (std::size_t i = 0; i < 40; ++i) {
    deaf.emplace_back(server.port());
    REQUIRE(deaf.back().send(get_request("/large.bin", server.port())));
  }
  for (int i = 0; i < 5; ++i) server.check_alive();
  // A client that reads late gets all of it.
  const auto late = deaf.back().read();
  REQUIRE(late);
  server.check_answer("/large.bin", *late);
}

TEST_CASE("more connections than are served leave room for the next") {
  const Attacked server;
  std::vector<RawConnection> idle;
  for (std::size_t i = 0; i < 400; ++i) {
    idle.emplace_back(server.port());
    if (i % 2 == 0) idle.back().send("GET / HT");
  }
  for (int i = 0; i < 5; ++i) server.check_alive();
}

TEST_CASE("broken connections leave nothing behind") {
  const Attacked server;
  const std::string whole = get_request("/large.bin", server.port());
  for (std::size_t i = 0; i < 300; ++i) {
    RawConnection connection(server.port());
    connection.send(whole.substr(0, i % 3 == 0 ? whole.size() : i % whole.size()));
    if (i % 5 == 0) std::this_thread::sleep_for(milliseconds(1));
    if (i % 2 == 0) connection.reset();
  }
  server.check_alive();
}

TEST_CASE("requests that come together or in pieces are answered one after the other") {
  const Attacked server;
  RawConnection connection(server.port());
  std::string all;
  for (int i = 0; i < 20; ++i) all += get_request(i % 2 == 0 ? "/mesh.bin" : "/none.bin", server.port());
  for (std::size_t at = 0; at < all.size(); at += 7) REQUIRE(connection.send(all.substr(at, 7)));
  for (int i = 0; i < 20; ++i) {
    const auto answer = connection.read();
    REQUIRE(answer);
    server.check_answer(i % 2 == 0 ? "/mesh.bin" : "/none.bin", *answer);
  }
}

TEST_CASE("a hundred clients at once get all their files whole") {
  const Attacked server;
  std::atomic<int> whole = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 100; ++i) {
    clients.emplace_back([&server, &whole, i] {
      try {
        RawConnection connection(server.port());
        for (const auto& [path, file] : server.files()) {
          if (file.size() > 1000000 && i % 10 != 0) continue;
          if (!connection.send(get_request(path, server.port()))) return;
          const auto answer = connection.read(false, seconds(60));
          if (!answer || answer->status != 200 || answer->body != file) return;
        }
        ++whole;
      } catch (const std::runtime_error&) {  // told by the count
      }
    });
  }
  for (std::thread& client : clients) client.join();
  CHECK(whole == 100);
  server.check_alive();
}

}  // namespace
}  // namespace lumatlas
