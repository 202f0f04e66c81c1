// SPDX-License-Identifier: GPL-3.0-or-later
// This is not Boost.Process: a child must end with its parent (PR_SET_PDEATHSIG) and start with no signal blocked, for
// which that has no words, and Debian 12's needs a compiled Boost.Filesystem besides.
#include "tools/base/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <sstream>
#include <thread>

#include "mesh/base/errors.h"
#include "tools/base/interrupt.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr int kCannotStart = 127;

// Between fork and exec only calls that are safe there: other threads may have held any lock.
[[noreturn]] void become(const ChildProcess& child, char* const* argv, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kCannotStart);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const int in = open("/dev/null", O_RDONLY);
  const int out = open(child.out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  const int err = child.err == child.out ? out : open(child.err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
  if (in < 0 || out < 0 || err < 0) _exit(kCannotStart);
  dup2(in, STDIN_FILENO);
  dup2(out, STDOUT_FILENO);
  dup2(err, STDERR_FILENO);
  execv(child.program.c_str(), argv);
  _exit(kCannotStart);
}

int wait_for(pid_t child, const std::function<void()>& while_waiting) {
  constexpr auto kPause = std::chrono::milliseconds(5);
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) break;
    if (ended < 0 && errno != EINTR) throw InputError(std::string("a program was lost: ") + std::strerror(errno));
    try {
      throw_if_interrupted();
      if (while_waiting) while_waiting();
    } catch (...) {
      kill(child, SIGTERM);
      waitpid(child, &status, 0);
      throw;
    }
    std::this_thread::sleep_for(kPause);
  }
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

std::string quoted(const std::string& word) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || std::strchr("-_./=,:+@%", c) != nullptr; };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

int run_to_end(const ChildProcess& child, const std::function<void()>& while_waiting) {
  std::vector<std::string> texts{child.program.string()};
  texts.insert(texts.end(), child.arguments.begin(), child.arguments.end());
  std::vector<char*> argv;
  argv.reserve(texts.size() + 1);
  for (std::string& text : texts) argv.push_back(text.data());
  argv.push_back(nullptr);
  const pid_t parent = getpid();
  const pid_t started = fork();
  if (started == 0) become(child, argv.data(), parent);
  if (started < 0) throw InputError(child.program.string() + ": cannot be started: " + std::strerror(errno));
  const int status = wait_for(started, while_waiting);
  throw_if_interrupted();  // Ctrl-C on a terminal goes to both
  if (status == kCannotStart) throw InputError(child.program.string() + ": cannot be started");
  return status;
}

fs::path find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::stringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    fs::path program = fs::path(folder.empty() ? "." : folder) / name;
    std::error_code ignored;
    if (fs::is_regular_file(program, ignored) && access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

std::string shell_line(const std::string& program, const std::vector<std::string>& arguments) {
  std::string line = quoted(program);
  for (const std::string& argument : arguments) line += " " + quoted(argument);
  return line;
}

}  // namespace lumatlas
