// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/viewer/browser.h"

#include <fcntl.h>
#include <httplib.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/process/child_process.h"
#include "tools/viewer/http/files_together.h"

namespace lumatlas {

namespace {

constexpr auto kPatience = std::chrono::seconds(420);  // a machine that is busy draws slowly

// A program and all that it starts, ended together.
class ProgramGroup {
 public:
  explicit ProgramGroup(std::vector<std::string> arguments) {
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
      posix_spawn_file_actions_addopen(&files, stream, "/dev/null", O_WRONLY, 0);
    }
    const int failed = posix_spawn(&group_, pointers[0], &files, &attributes, pointers.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (failed != 0) throw std::runtime_error(arguments[0] + " cannot be started");
  }
  ~ProgramGroup() {
    kill(-group_, SIGKILL);
    waitpid(group_, nullptr, 0);
  }
  ProgramGroup(const ProgramGroup&) = delete;
  ProgramGroup& operator=(const ProgramGroup&) = delete;

 private:
  pid_t group_ = 0;
};

// Every byte but letters and digits as %XX.
std::string percent_encoded(const std::string& text) {
  std::string encoded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) {
      encoded += c;
    } else {
      encoded += '%';
      for (const int digit : {byte / 16, byte % 16}) encoded += "0123456789ABCDEF"[digit];
    }
  }
  return encoded;
}

// Chromium, which opens and closes tabs when it is asked by HTTP. To start it takes as long as a short test.
class Browser {
 public:
  explicit Browser(const std::filesystem::path& chromium)
      : program_({chromium.string(), "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
                  "--enable-unsafe-swiftshader", "--disable-gpu", "--disable-quic", "--no-first-run",
                  "--disable-background-networking", "--disable-component-update", "--disable-sync",
                  "--disable-dev-shm-usage", "--user-data-dir=" + profile_.path().string(), "--window-size=640,480",
                  "--remote-debugging-port=0", "about:blank"}) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (port_ == 0) {
      if (std::chrono::steady_clock::now() > deadline) throw std::runtime_error("chromium opens no port");
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      // Its first line is the port, and the second shows that the first is whole.
      std::ifstream file(profile_.path() / "DevToolsActivePort");
      std::string port, rest;
      if (file >> port >> rest) port_ = std::stoi(port);
    }
  }

  // Returns the answer to a request that changes tabs, such as "new?URL".
  [[nodiscard]] std::string ask(const std::string& request) const {
    httplib::Client client("127.0.0.1", port_);
    client.set_read_timeout(kPatience);
    const httplib::Result result = client.Put("/json/" + request);
    if (!result || result->status != 200) throw std::runtime_error("chromium does not answer to " + request);
    return result->body;
  }

 private:
  TemporaryFolder profile_;
  ProgramGroup program_;
  int port_ = 0;
};

// A page that is shown as long as this lives.
class BrowserTab {
 public:
  BrowserTab(const Browser& browser, const std::string& url)
      : browser_(browser), id_(nlohmann::json::parse(browser.ask("new?" + percent_encoded(url)))["id"]) {}
  ~BrowserTab() {
    try {
      (void)browser_.ask("close/" + id_);
    } catch (const std::exception& error) {
      UNSCOPED_INFO(error.what());
      CHECK(false);
    }
  }
  BrowserTab(const BrowserTab&) = delete;
  BrowserTab& operator=(const BrowserTab&) = delete;

 private:
  const Browser& browser_;
  std::string id_;
};

// The first half of a file. `promised`: in an answer that promises all of it.
void answer_half(const SiteFile& file, bool promised, httplib::Response& response) {
  const auto* bytes = reinterpret_cast<const char*>(file.bytes.data());
  const std::size_t half = file.bytes.size() / 2;
  if (promised) {
    response.set_content_provider(file.bytes.size(), file.type,
                                  [=](std::size_t offset, std::size_t, httplib::DataSink& sink) {
                                    return offset < half && sink.write(bytes + offset, half - offset);
                                  });
  } else {
    response.set_chunked_content_provider(file.type, [=](std::size_t, httplib::DataSink& sink) {
      sink.write(bytes, half);
      sink.done();
      return true;
    });
  }
}

void answer(const SiteFile& file, const Trouble& trouble, httplib::Response& response) {
  using Kind = Trouble::Kind;
  std::this_thread::sleep_for(trouble.delay);
  switch (trouble.kind) {
    case Kind::none:
      return response.set_content(std::string(file.bytes.begin(), file.bytes.end()), file.type);
    case Kind::refused:
    case Kind::missing:
      response.status = trouble.kind == Kind::refused ? 503 : 404;
      return response.set_content("no", "text/plain");
    case Kind::cut:
    case Kind::shortened:
      return answer_half(file, trouble.kind == Kind::cut, response);
  }
}

// Answers as SiteServer does, for the files of a folder.
void answer_together(const std::vector<SiteFile>& files, const httplib::Request& request, httplib::Response& response) {
  const std::string folder = request.matches[1];
  const std::vector<std::uint8_t> bytes =
      files_together(request.target.substr(request.target.find('?') + 1), [&](const std::string& name) {
        const auto found =
            std::find_if(files.begin(), files.end(), [&](const SiteFile& file) { return file.name == folder + name; });
        return found == files.end() ? nullptr : std::make_shared<const SiteFile>(*found);
      });
  response.set_content(std::string(bytes.begin(), bytes.end()), "application/octet-stream");
}

// Answers what pages ask for, and keeps what they say.
class TestServer {
 public:
  TestServer(const std::vector<SiteFile>& files, const Network& network) {
    for (const SiteFile& file : files) {
      server_.Get("/" + file.name, [&file, &network](const httplib::Request&, httplib::Response& response) {
        answer(file, network ? network(file.name) : Trouble{}, response);
      });
    }
    server_.Get("/(.+/)together", [&files](const httplib::Request& request, httplib::Response& response) {
      answer_together(files, request, response);
    });
    const auto listen = [this](const httplib::Request& request, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      // A page from a disk may post nothing, but it may ask for an address.
      said_[request.matches[1]] += request.method == "GET" ? request.target : request.body;
      response.set_content("heard", "text/plain");
      heard_.notify_all();
    };
    server_.Post("/said/(.*)", listen);
    server_.Get("/said/(.*)", listen);
    // Its end waits for connections that the browser holds open.
    server_.set_keep_alive_max_count(1);
    server_.set_keep_alive_timeout(1);
    port_ = server_.bind_to_any_port("127.0.0.1");
    thread_ = std::thread([this] { server_.listen_after_bind(); });
    while (!server_.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ~TestServer() {
    server_.stop();
    thread_.join();
  }
  TestServer(const TestServer&) = delete;
  TestServer& operator=(const TestServer&) = delete;

  [[nodiscard]] std::string address() const { return "http://127.0.0.1:" + std::to_string(port_); }

  Said wait_for_end() {
    std::unique_lock lock(mutex_);
    const bool ended = heard_.wait_for(lock, kPatience, [&] { return said_.contains("done"); });
    INFO("the page says: " << problem_of(said_));
    CHECK(ended);
    return said_;
  }

 private:
  httplib::Server server_;
  int port_ = 0;
  std::thread thread_;
  std::mutex mutex_;
  std::condition_variable heard_;
  Said said_;
};

}  // namespace

Said said_in_browser(const std::vector<SiteFile>& files, const std::string& start, const Network& network) {
  const std::filesystem::path chromium = find_program("chromium");
  if (chromium.empty()) {
    skip("there is no chromium");
    return {};
  }
  static const Browser browser(chromium);
  TestServer server(files, network);
  std::string url = start;
  if (const std::size_t at = url.find("{{server}}"); at != std::string::npos) url.replace(at, 10, server.address());
  if (url.starts_with("/")) url = server.address() + url;
  const BrowserTab tab(browser, url);
  return server.wait_for_end();
}

std::string problem_of(const Said& said) {
  const auto found = said.find("problem");
  return found == said.end() ? "" : found->second;
}

}  // namespace lumatlas
