// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/viewer/browser.h"

#include <fcntl.h>
#include <httplib.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "tests/support/skip.h"
#include "tests/support/temporary_folder.h"
#include "tools/base/process/child_process.h"

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

// The first half of a file. `promised`: in an answer that promises all of it.
void answer_half(const SiteFile& file, bool promised, httplib::Response& response) {
  const auto* bytes = reinterpret_cast<const char*>(file.bytes.data());
  const std::size_t half = file.bytes.size() / 2;
  if (promised) {
    response.set_content_provider(file.bytes.size(), file.type.c_str(),
                                  [=](std::size_t offset, std::size_t, httplib::DataSink& sink) {
                                    return offset < half && sink.write(bytes + offset, half - offset);
                                  });
  } else {
    response.set_chunked_content_provider(file.type.c_str(), [=](std::size_t, httplib::DataSink& sink) {
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
      return response.set_content(std::string(file.bytes.begin(), file.bytes.end()), file.type.c_str());
    case Kind::refused:
    case Kind::missing:
      response.status = trouble.kind == Kind::refused ? 503 : 404;
      return response.set_content("no", "text/plain");
    case Kind::cut:
    case Kind::shortened:
      return answer_half(file, trouble.kind == Kind::cut, response);
  }
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
    const auto listen = [this](const httplib::Request& request, httplib::Response& response) {
      const std::lock_guard lock(mutex_);
      // A page from a disk may post nothing, but it may ask for an address.
      said_[request.matches[1]] += request.method == "GET" ? request.target : request.body;
      response.set_content("heard", "text/plain");
      heard_.notify_all();
    };
    server_.Post("/said/(.*)", listen);
    server_.Get("/said/(.*)", listen);
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

Said said_in_browser(const std::vector<SiteFile>& files, const std::string& start, int width, int height,
                     const Network& network) {
  const std::filesystem::path chromium = find_program("chromium");
  if (chromium.empty()) {
    skip("there is no chromium");
    return {};
  }
  TestServer server(files, network);
  const TemporaryFolder profile;
  std::string url = start;
  if (const std::size_t at = url.find("{{server}}"); at != std::string::npos) url.replace(at, 10, server.address());
  if (url.starts_with("/")) url = server.address() + url;
  const ProgramGroup browser({chromium.string(), "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
                              "--enable-unsafe-swiftshader", "--disable-gpu", "--disable-quic", "--no-first-run",
                              "--disable-background-networking", "--disable-component-update", "--disable-sync",
                              "--disable-dev-shm-usage", "--user-data-dir=" + profile.path().string(),
                              "--window-size=" + std::to_string(width) + "," + std::to_string(height), url});
  return server.wait_for_end();
}

std::string problem_of(const Said& said) {
  const auto found = said.find("problem");
  return found == said.end() ? "" : found->second;
}

}  // namespace lumatlas
