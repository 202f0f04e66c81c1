// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/interrupt.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "tests/support/temporary_folder.h"
#include "tools/base/output_folder.h"
#include "tools/base/progress.h"

namespace lumatlas {
namespace {

constexpr int kEnded = 41;  // exit code of a child that ran to its end

// Runs `work` in a child as main() would, the default signal actions in force at its start. Its wait status.
int wait_status_of(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    signal(SIGINT, SIG_DFL);
    signal(SIGTERM, SIG_DFL);
    signal(SIGHUP, SIG_DFL);
    signal(SIGPIPE, SIG_DFL);
    try {
      work();
    } catch (const Interrupted& interrupted) {
      die_of(interrupted);
    }
    _exit(kEnded);
  }
  int status = 0;
  REQUIRE(child > 0);
  REQUIRE(waitpid(child, &status, 0) == child);
  return status;
}

bool died_of(int status, int signal) {
  return WIFSIGNALED(status) && WTERMSIG(status) == signal;
}
bool ended(int status) {
  return WIFEXITED(status) && WEXITSTATUS(status) == kEnded;
}

// Work like the program's: an output that grows while progress ticks; the signal comes at the third tick of ten.
void write_output(const std::filesystem::path& path, int signal) {
  OutputFolder out(path, "synth");
  std::ostringstream lines;
  ProgressOptions options;
  options.out = &lines;
  Progress progress("writing", 10, options);
  for (int i = 0; i < 10; ++i) {
    std::ofstream(out.path() / std::to_string(i)) << i;
    if (i == 2) {
      raise(signal);
    }
    progress.tick();
  }
  out.commit({});
}

TEST_CASE("an interrupted program removes its half-written output and dies of the signal") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    const TemporaryFolder folder;
    const int status = wait_status_of([&] {
      install_interrupt_handler();
      write_output(folder.path() / "sub" / "out", signal);
    });
    CHECK(died_of(status, signal));
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}

TEST_CASE("work that does not ask is ended all the same, soon, and its half-written output removed") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) {
    const TemporaryFolder folder;
    const auto start = std::chrono::steady_clock::now();
    const int status = wait_status_of([&] {
      install_interrupt_handler();
      const OutputFolder out(folder.path() / "out", "synth");
      std::ofstream(out.path() / "half") << "half";
      raise(signal);
      while (true) std::this_thread::sleep_for(std::chrono::seconds(1));
    });
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    CHECK(died_of(status, signal));
    CHECK(taken.count() < 5);  // at most one on a machine with nothing else to do
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}

TEST_CASE("without a signal nothing is thrown") {
  CHECK(ended(wait_status_of([] {
    install_interrupt_handler();
    throw_if_interrupted();
  })));
}

TEST_CASE("the first signal alone does not end the program, the second does, even if it is another one") {
  CHECK(ended(wait_status_of([] {
    install_interrupt_handler();
    raise(SIGINT);
  })));
  CHECK(died_of(wait_status_of([] {
                  install_interrupt_handler();
                  raise(SIGINT);
                  raise(SIGTERM);
                }),
                SIGTERM));
}

TEST_CASE("a closed terminal and a pipe without a reader repeat themselves, and do not kill at once") {
  for (const int signal : {SIGHUP, SIGPIPE}) {
    CHECK(ended(wait_status_of([&] {
      install_interrupt_handler();
      for (int i = 0; i < 3; ++i) raise(signal);
    })));
  }
}

TEST_CASE("a signal that the program was started to ignore stays ignored") {
  CHECK(ended(wait_status_of([] {
    signal(SIGINT, SIG_IGN);
    install_interrupt_handler();
    raise(SIGINT);
    raise(SIGINT);
    throw_if_interrupted();
  })));
  CHECK(died_of(wait_status_of([] {
                  signal(SIGINT, SIG_IGN);
                  install_interrupt_handler();
                  raise(SIGTERM);
                  throw_if_interrupted();
                }),
                SIGTERM));
}

TEST_CASE("a request to end takes the first Ctrl-C, and nothing else; the next is as without it") {
  const auto requested = [](std::initializer_list<int> signals) {
    return wait_status_of([&] {
      install_interrupt_handler();
      EndRequest request;
      for (const int signal : signals) {
        raise(signal);
        if (signal == SIGINT && !request.made()) _exit(1);
      }
      throw_if_interrupted();
    });
  };
  CHECK(ended(requested({SIGINT})));
  CHECK(died_of(requested({SIGINT, SIGINT}), SIGINT));
  CHECK(died_of(requested({SIGTERM}), SIGTERM));
  CHECK(died_of(wait_status_of([] {
                  install_interrupt_handler();
                  { const EndRequest over; }
                  raise(SIGINT);
                  throw_if_interrupted();
                }),
                SIGINT));
}

TEST_CASE("an interruption names its signal") {
  CHECK(ended(wait_status_of([] {
    install_interrupt_handler();
    raise(SIGTERM);
    try {
      throw_if_interrupted();
    } catch (const Interrupted& interrupted) {
      _exit(interrupted.signal() == SIGTERM ? kEnded : 1);
    }
  })));
}

}  // namespace
}  // namespace lumatlas
