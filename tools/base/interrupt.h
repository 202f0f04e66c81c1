// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C as an exception, so that half-written outputs vanish by unwinding.
#pragma once

#include <exception>

namespace lumatlas {

// Somebody asked the program to stop. main() lets it unwind and then calls die_of.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int signal) : signal_(signal) {}
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
  [[nodiscard]] int signal() const { return signal_; }

 private:
  int signal_;
};

// From now on the first SIGINT or SIGTERM only makes throw_if_interrupted throw; the second kills at once. A signal
// that the program was started to ignore (nohup, a background job) stays ignored.
void install_interrupt_handler();

// Throws Interrupted once a signal has come. Cheap, and safe from any thread.
void throw_if_interrupted();

// Ends the program by the signal itself, so that the shell sees what happened (a script's loop then stops too).
[[noreturn]] void die_of(const Interrupted& interrupted);

}  // namespace lumatlas
