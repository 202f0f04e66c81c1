// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/child_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <thread>

#include "mesh/base/errors.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

namespace fs = std::filesystem;

// A zombie has ended, even if no process waits for it.
bool is_running(const std::string& process) {
  std::ifstream file("/proc/" + process + "/stat");
  std::string stat;
  std::getline(file, stat);
  const std::size_t end_of_name = stat.rfind(')');
  return end_of_name != std::string::npos && stat.at(end_of_name + 2) != 'Z';
}

template <typename Condition>
bool comes_true(const Condition& condition) {
  for (int wait = 0; wait < 1000 && !condition(); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return condition();
}

// A program that starts another one and waits for it; both ignore SIGTERM. Each writes its number into a file.
class Stubborn {
 public:
  Stubborn() {
    std::ofstream(folder_ / "program") << "#!/bin/sh\n"
                                          "trap '' TERM\n"
                                          "cd \"$(dirname \"$0\")\"\n"
                                          "sh -c 'trap \"\" TERM; echo $$ > inner; while :; do sleep 1; done' &\n"
                                          "echo $$ > outer\n"
                                          "while :; do sleep 1; done\n";
    fs::permissions(folder_ / "program", fs::perms::owner_all);
  }
  [[nodiscard]] ChildProcess program() const { return {folder_ / "program", {}, folder_ / "log", folder_ / "log"}; }
  [[nodiscard]] bool has_started() const {
    return outer().find('\n') != std::string::npos && inner().find('\n') != std::string::npos;
  }
  [[nodiscard]] bool has_ended() const {
    return !is_running(without_end(outer())) && !is_running(without_end(inner()));
  }

 private:
  [[nodiscard]] std::string outer() const { return bytes_of(folder_ / "outer"); }
  [[nodiscard]] std::string inner() const { return bytes_of(folder_ / "inner"); }
  static std::string without_end(std::string line) { return line.substr(0, line.find('\n')); }

  TemporaryFolder folder_;
};

TEST_CASE("a program that ignores being asked to end is killed after a moment, with what it has started") {
  const Stubborn stubborn;
  auto asked = std::chrono::steady_clock::now();
  CHECK_THROWS_AS(run_to_end(stubborn.program(),
                             [&] {
                               if (!stubborn.has_started()) return;
                               asked = std::chrono::steady_clock::now();
                               throw std::runtime_error("enough");
                             }),
                  std::runtime_error);
  CHECK(std::chrono::steady_clock::now() - asked < std::chrono::seconds(5));  // 0.3 s, on a machine that is busy
  CHECK(comes_true([&] { return stubborn.has_ended(); }));
}

TEST_CASE("where the program itself is killed at once, what it has started ends too, soon") {
  const Stubborn stubborn;
  const pid_t program = fork();
  if (program == 0) {
    (void)run_to_end(stubborn.program());
    _exit(0);
  }
  REQUIRE(comes_true([&] { return stubborn.has_started(); }));
  kill(program, SIGKILL);
  int status = 0;
  REQUIRE(waitpid(program, &status, 0) == program);
  CHECK(comes_true([&] { return stubborn.has_ended(); }));
}

TEST_CASE("what a program leaves running when it ends is ended") {
  const TemporaryFolder folder;
  const fs::path log = folder / "log";
  CHECK(run_to_end({"/bin/sh", {"-c", "sleep 100 & echo $!"}, log, log}) == 0);
  const std::string left = bytes_of(log);
  CHECK(comes_true([&] { return !is_running(left.substr(0, left.find('\n'))); }));
}

TEST_CASE("a program's exit status and the signal that ended it are told, and so is one that cannot be started") {
  const TemporaryFolder folder;
  const fs::path log = folder / "log";
  CHECK(run_to_end({"/bin/sh", {"-c", "exit 7"}, log, log}) == 7);
  CHECK(run_to_end({"/bin/sh", {"-c", "kill -SEGV $$"}, log, log}) == -SIGSEGV);
  CHECK(run_to_end({"/bin/sh", {"-c", "echo said; echo asked >&2; read -r line || echo nothing"}, log, log}) == 0);
  CHECK(bytes_of(log) == "said\nasked\nnothing\n");
  CHECK_THROWS_AS(run_to_end({folder / "nowhere", {}, log, log}), InputError);
}

}  // namespace
}  // namespace lumatlas
