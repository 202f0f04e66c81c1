// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/hang_report.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <sstream>
#include <string>
#include <thread>

#include "tests/support/temporary_folder.h"
#include "tools/base/process/child_process.h"

namespace lumatlas {
namespace {

// A stack begins with the handler that writes it, which is in this program.
int stacks_in(const std::string& report) {
  std::istringstream lines(report);
  int stacks = 0;
  bool follows_thread = false;
  for (std::string line; std::getline(lines, line);) {
    if (follows_thread && line.find("base_tests") != std::string::npos) ++stacks;
    follows_thread = line.rfind("thread ", 0) == 0;
  }
  return stacks;
}

TEST_CASE("a hang report has the stack of each thread, and the processes below") {
  const TemporaryFolder folder;
  const pid_t sleeping = start_program("/bin/sleep", {"60"});
  std::atomic<bool> may_end{false};
  std::thread waiting([&] {
    while (!may_end) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  const int report = open((folder / "report").c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  REQUIRE(report >= 0);
  write_stacks(report);
  close(report);
  may_end = true;
  waiting.join();
  kill(sleeping, SIGKILL);
  waitpid(sleeping, nullptr, 0);

  const std::string text = bytes_of(folder / "report");
  INFO(text);
  CHECK(stacks_in(text) >= 2);
  CHECK_THAT(text, Catch::Contains("/bin/sleep 60"));
}

}  // namespace
}  // namespace lumatlas
