// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace lumatlas {

namespace {

std::atomic<int> received_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler writes it");

// Only calls that are safe in a signal handler.
void remember_signal(int signal) {
  received_signal.store(signal);
  ::signal(SIGINT, SIG_DFL);
  ::signal(SIGTERM, SIG_DFL);
}

void handle(int signal) {
  struct sigaction previous {};
  sigaction(signal, nullptr, &previous);
  if (previous.sa_handler == SIG_IGN) {
    return;
  }
  struct sigaction action {};
  action.sa_handler = remember_signal;
  action.sa_flags = SA_RESTART;  // libraries that read files need not know of us
  sigemptyset(&action.sa_mask);
  sigaction(signal, &action, nullptr);
}

}  // namespace

void install_interrupt_handler() {
  handle(SIGINT);
  handle(SIGTERM);
}

void throw_if_interrupted() {
  if (const int signal = received_signal.load(std::memory_order_relaxed); signal != 0) {
    throw Interrupted(signal);
  }
}

void die_of(const Interrupted& interrupted) {
  const int signal = interrupted.signal();
  ::signal(signal, SIG_DFL);
  sigset_t only_this;
  sigemptyset(&only_this);
  sigaddset(&only_this, signal);
  sigprocmask(SIG_UNBLOCK, &only_this, nullptr);
  raise(signal);
  _exit(128 + signal);  // what a shell makes of such a death, should the signal not have killed
}

}  // namespace lumatlas
