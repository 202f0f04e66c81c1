// SPDX-License-Identifier: GPL-3.0-or-later
// This is not Boost.Process: a child must end with its parent, with all that it started, and start with no signal
// blocked. Boost.Process has no functions for these, and Debian 12's needs a compiled Boost.Filesystem besides.
#include "tools/base/process/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <sstream>
#include <thread>

#include "mesh/base/errors.h"
#include "tools/base/process/interrupt.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr int kCannotStart = 127;

// Time that the other program has to end by itself once it was asked to, below kUnwindingTime.
constexpr auto kEndingTime = std::chrono::milliseconds(300);
static_assert(kEndingTime < kUnwindingTime);
constexpr timespec kKeepersNap{0, 5'000'000};

constexpr std::array kForwarded{SIGINT, SIGHUP, SIGPIPE, SIGTERM};

volatile std::sig_atomic_t must_end = 0;  // in the keeper

void note_end(int /*signal*/) {
  must_end = 1;
}

void set_action(int signal, void (*action)(int)) {
  struct sigaction wanted {};
  wanted.sa_handler = action;
  sigemptyset(&wanted.sa_mask);
  sigaction(signal, &wanted, nullptr);
}

// The other program, in a process group of its own. It ends with its keeper.
[[noreturn]] void become(const ChildProcess& child, char* const* argv, pid_t keeper) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != keeper) _exit(kCannotStart);
  setpgid(0, 0);
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

// Returns whether the child has ended. It stays a zombie, so that no other process gets its number.
bool has_ended(pid_t child) {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == child;
}

// Ends as the other program did.
[[noreturn]] void end_as(int status) {
  if (WIFEXITED(status)) _exit(WEXITSTATUS(status));
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  set_action(WTERMSIG(status), SIG_DFL);
  raise(WTERMSIG(status));
  _exit(kCannotStart);
}

// A process between this program and the other one. It starts the other program, and sees to it that neither it nor
// what it starts outlives this program, however this program ends: asked to end by SIGTERM, or left without its parent,
// it asks the group of the other program to end, and kills the group after kEndingTime. Only calls that are safe after
// a fork: other threads of the parent may have held any lock.
[[noreturn]] void keep(const ChildProcess& child, char* const* argv, pid_t parent) {
  std::array<bool, kForwarded.size()> was_ignored{};
  for (std::size_t i = 0; i < kForwarded.size(); ++i) {
    struct sigaction present {};
    sigaction(kForwarded[i], nullptr, &present);
    was_ignored[i] = present.sa_handler == SIG_IGN;
    set_action(kForwarded[i], kForwarded[i] == SIGTERM ? note_end : SIG_IGN);
  }
  const pid_t keeper = getpid();
  const pid_t started = _Fork();
  if (started == 0) {
    for (std::size_t i = 0; i < kForwarded.size(); ++i) set_action(kForwarded[i], was_ignored[i] ? SIG_IGN : SIG_DFL);
    become(child, argv, keeper);
  }
  if (started < 0) _exit(kCannotStart);
  setpgid(started, started);     // whichever of the two is first
  (void)close_range(3, ~0U, 0);  // locks and sockets of the program are not held any longer than it lives
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  while (!has_ended(started) && must_end == 0 && getppid() == parent) nanosleep(&kKeepersNap, nullptr);
  kill(-started, SIGTERM);
  for (auto waited = std::chrono::nanoseconds(0); !has_ended(started) && waited < kEndingTime;) {
    nanosleep(&kKeepersNap, nullptr);
    waited += std::chrono::nanoseconds(kKeepersNap.tv_nsec);
  }
  kill(-started, SIGKILL);
  int status = 0;
  waitpid(started, &status, 0);
  end_as(status);
}

int wait_for(pid_t keeper, const std::function<void()>& while_waiting) {
  constexpr auto kPause = std::chrono::milliseconds(5);
  int status = 0;
  while (true) {
    const pid_t ended = waitpid(keeper, &status, WNOHANG);
    if (ended == keeper) break;
    if (ended < 0 && errno != EINTR) throw InputError(std::string("a program was lost: ") + std::strerror(errno));
    try {
      throw_if_interrupted();
      if (while_waiting) while_waiting();
    } catch (...) {
      kill(keeper, SIGTERM);
      waitpid(keeper, &status, 0);
      throw;
    }
    std::this_thread::sleep_for(kPause);
  }
  return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
}

// The arguments of a program as execv() takes them: its name, then these.
class ArgumentList {
 public:
  ArgumentList(const fs::path& program, const std::vector<std::string>& arguments) : texts_{program.string()} {
    texts_.insert(texts_.end(), arguments.begin(), arguments.end());
    for (std::string& text : texts_) pointers_.push_back(text.data());
    pointers_.push_back(nullptr);
  }
  [[nodiscard]] char* const* data() const { return pointers_.data(); }

 private:
  std::vector<std::string> texts_;
  std::vector<char*> pointers_;
};

std::string quoted(const std::string& word) {
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) != 0 || std::strchr("-_./=,:+@%", c) != nullptr; };
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

int run_to_end(const ChildProcess& child, const std::function<void()>& while_waiting) {
  const ArgumentList argv(child.program, child.arguments);
  const pid_t parent = getpid();
  // Until the keeper has its own handlers, a signal would run those of this program in it, and be lost.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  // _Fork() runs no fork handlers of libraries. Another thread may hold their locks, which the keeper then waits for.
  const pid_t started = _Fork();
  if (started == 0) keep(child, argv.data(), parent);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (started < 0) throw InputError(child.program.string() + ": cannot be started: " + std::strerror(errno));
  const int status = wait_for(started, while_waiting);
  throw_if_interrupted();  // Ctrl-C on a terminal goes to both
  if (status == kCannotStart) throw InputError(child.program.string() + ": cannot be started");
  return status;
}

pid_t start_program(const fs::path& program, const std::vector<std::string>& arguments,
                    const StandardStreams& streams) {
  const ArgumentList argv(program, arguments);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  const std::array<int, 3> given{streams.in, streams.out, streams.err};
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    const int descriptor = given[static_cast<std::size_t>(stream)];
    if (descriptor >= 0) {
      posix_spawn_file_actions_adddup2(&files, descriptor, stream);
    } else {
      posix_spawn_file_actions_addopen(&files, stream, "/dev/null", stream == STDIN_FILENO ? O_RDONLY : O_WRONLY, 0);
    }
  }
  pid_t started = 0;
  const int error = posix_spawn(&started, program.c_str(), &files, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  if (error != 0) throw InputError(program.string() + ": cannot be started: " + std::strerror(error));
  return started;
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
