// SPDX-License-Identifier: GPL-3.0-or-later
// The built program as a process of its own, under whatever a hostile surrounding gives it.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace lumatlas {

using Arguments = std::vector<std::string>;

struct Outcome {
  int status = 0;  // exit status, or minus the signal that ended it
  std::string out;
  std::string err;
};

// A program that is running, its streams going to files in a folder of its own.
class Run {
 public:
  // `before` is called in the new process just before the program starts: to set limits, close streams, ignore signals.
  explicit Run(Arguments arguments, const std::function<void()>& before = {}) {
    arguments.insert(arguments.begin(), LUMATLAS_PROGRAM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string out = (streams_ / "out").string();
    const std::string err = (streams_ / "err").string();
    child_ = fork();
    if (child_ == 0) {
      dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
      dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDOUT_FILENO);
      dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
      for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGPIPE}) ::signal(signal, SIG_DFL);
      if (before) before();
      execv(argv[0], argv.data());
      _exit(127);
    }
    REQUIRE(child_ > 0);
  }
  void send(int signal) const { kill(child_, signal); }
  // Until `is_so` holds, or the program has had half a minute for it.
  template <typename Condition>
  static void wait_until(const Condition& is_so) {
    for (int wait = 0; wait < 15000 && !is_so(); ++wait) std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  [[nodiscard]] Outcome wait() const {
    int status = 0;
    REQUIRE(waitpid(child_, &status, 0) == child_);
    const int code = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
    return {code, bytes_of(streams_ / "out"), bytes_of(streams_ / "err")};
  }

 private:
  TemporaryFolder streams_;
  pid_t child_ = -1;
};

inline Outcome lumatlas(const Arguments& arguments, const std::function<void()>& before = {}) {
  return Run(arguments, before).wait();
}

// Exit status 1 and one sentence for the user, that starts as every failure does.
inline void check_failure(const Outcome& outcome, const std::string& part) {
  INFO(outcome.err);
  CHECK(outcome.status == 1);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::StartsWith("lumatlas: ") && Catch::Contains(part));
  CHECK(outcome.err.find('\n') == outcome.err.size() - 1);
}

}  // namespace lumatlas
