// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <system_error>
#include <thread>

#include "mesh/base/temporary_entry.h"

namespace lumatlas {

namespace {

constexpr std::array kSignals{SIGINT, SIGTERM, SIGHUP, SIGPIPE};

std::atomic<int> received_signal{0};
std::atomic<int> wake_watcher{-1};                // a pipe's end
enum Request : int { kNotTaken, kTaken, kMade };  // whether SIGINT counts as an EndRequest
std::atomic<int> end_request{kNotTaken};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");

bool kills_when_repeated(int signal) {
  return signal == SIGINT || signal == SIGTERM;  // people repeat these; the others repeat themselves
}

bool is_ignored(int signal) {
  struct sigaction present {};
  sigaction(signal, nullptr, &present);
  return present.sa_handler == SIG_IGN;
}

// A handler rather than SIG_IGN, which other programs that are started would inherit.
void do_nothing(int /*signal*/) {}

// Only calls that are safe in a signal handler.
void remember_signal(int signal) {
  int taken = kTaken;
  if (signal == SIGINT && end_request.compare_exchange_strong(taken, kMade)) return;
  const int error = errno;
  int none = 0;
  if (received_signal.compare_exchange_strong(none, signal)) {
    const char byte = 0;
    if (write(wake_watcher.load(), &byte, 1) < 0) errno = error;  // there is no watcher
  }
  for (const int other : kSignals) {
    if (kills_when_repeated(other) && !is_ignored(other)) ::signal(other, SIG_DFL);
  }
  errno = error;
}

void handle(int signal, void (*action_for_it)(int)) {
  if (is_ignored(signal)) return;
  struct sigaction action {};
  action.sa_handler = action_for_it;
  action.sa_flags = SA_RESTART;  // libraries that read files need not know of us
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

// In the watcher's thread, once a signal has come.
void end_after_unwinding_time() {
  std::this_thread::sleep_for(kUnwindingTime);
  remove_temporary_entries();
  die_of(Interrupted(received_signal.load()));
}

// A process that may start no further thread ends by unwinding alone.
void start_watcher() {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return;
  try {
    std::thread([input = ends[0]] {
      char byte = 0;
      while (read(input, &byte, 1) < 0 && errno == EINTR) {
      }
      end_after_unwinding_time();
    }).detach();
    wake_watcher.store(ends[1]);
  } catch (const std::system_error&) {
    close(ends[0]);
    close(ends[1]);
  }
}

}  // namespace

void install_interrupt_handler() {
  start_watcher();
  for (const int signal : kSignals) handle(signal, remember_signal);
  handle(SIGXFSZ, do_nothing);
}

void throw_if_interrupted() {
  if (const int signal = received_signal.load(std::memory_order_relaxed); signal != 0) {
    throw Interrupted(signal);
  }
}

EndRequest::EndRequest() {
  end_request.store(kTaken);
}

EndRequest::~EndRequest() {
  end_request.store(kNotTaken);
}

bool EndRequest::made() const {
  return end_request.load() == kMade;
}

void die_of(const Interrupted& interrupted) {
  const int signal = interrupted.signal();
  ::signal(signal, SIG_DFL);
  sigset_t only_this;
  sigemptyset(&only_this);
  sigaddset(&only_this, signal);
  pthread_sigmask(SIG_UNBLOCK, &only_this, nullptr);
  raise(signal);
  _exit(128 + signal);  // a shell's code for such a death, should the signal not have killed
}

}  // namespace lumatlas
