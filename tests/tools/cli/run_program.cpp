// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/tools/cli/run_program.h"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>

namespace lumatlas {

Run::Run(Arguments arguments, const std::function<void()>& before) {
  std::string program = LUMATLAS_PROGRAM;
  std::vector<char*> argv{program.data()};
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  const std::string out = (streams_ / "out").string();
  const std::string err = (streams_ / "err").string();
  // Until the child has given up the handlers of this program, a signal would run them in it, and could wait without
  // end for a lock that fork() holds.
  sigset_t all, mask;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &mask);
  child_ = fork();
  if (child_ == 0) {
    dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDOUT_FILENO);
    dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600), STDERR_FILENO);
    // A background job starts with some of them ignored.
    for (const int signal : {SIGINT, SIGHUP, SIGTERM, SIGPIPE}) ::signal(signal, SIG_DFL);
    pthread_sigmask(SIG_SETMASK, &mask, nullptr);
    if (before) before();
    execv(argv[0], argv.data());
    _exit(127);
  }
  pthread_sigmask(SIG_SETMASK, &mask, nullptr);
  REQUIRE(child_ > 0);
}

void Run::send(int signal) const {
  kill(child_, signal);
}

std::string Run::out() const {
  return bytes_of(streams_ / "out");
}

std::string Run::err() const {
  return bytes_of(streams_ / "err");
}

bool Run::has_ended() const {
  siginfo_t info{};
  REQUIRE(waitid(P_PID, static_cast<id_t>(child_), &info, WEXITED | WNOHANG | WNOWAIT) == 0);
  return info.si_pid == child_;
}

Outcome Run::wait() const {
  int status = 0;
  REQUIRE(waitpid(child_, &status, 0) == child_);
  const int code = WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  return {code, bytes_of(streams_ / "out"), bytes_of(streams_ / "err")};
}

Outcome lumatlas(const Arguments& arguments, const std::function<void()>& before) {
  Outcome outcome = Run(arguments, before).wait();
  INFO(outcome.err);
  if (!before) CHECK(outcome.status >= 0);
  return outcome;
}

void check_failure(const Outcome& outcome, const std::string& part) {
  INFO(outcome.err);
  CHECK(outcome.status == 1);
  CHECK(outcome.out.empty());
  CHECK_THAT(outcome.err, Catch::StartsWith("lumatlas: ") && Catch::Contains(part));
  CHECK(outcome.err.find('\n') == outcome.err.size() - 1);
}

}  // namespace lumatlas
