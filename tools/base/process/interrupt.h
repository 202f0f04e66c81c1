// SPDX-License-Identifier: GPL-3.0-or-later
// Ctrl-C, and what else asks a program to stop, as an exception, so that half-written outputs vanish by unwinding.
#pragma once

#include <chrono>
#include <exception>

namespace lumatlas {

// The user or the system asked the program to stop. main() lets it unwind and then calls die_of.
class Interrupted : public std::exception {
 public:
  explicit Interrupted(int signal) : signal_(signal) {}
  [[nodiscard]] const char* what() const noexcept override { return "interrupted"; }
  [[nodiscard]] int signal() const { return signal_; }

 private:
  int signal_;
};

// Time that the program has to clean up after the signal before it is killed.
inline constexpr auto kUnwindingTime = std::chrono::milliseconds(700);

// Lets the first SIGINT, SIGTERM, SIGHUP or SIGPIPE only make throw_if_interrupted throw. Work that does not
// ask for longer than kUnwindingTime is ended where it is: a thread that waits for this removes the outputs that are
// being written (remove_temporary_entries) and lets the process die of the signal. A second SIGINT or SIGTERM kills at
// once. A signal that the program was started to ignore (nohup, a background job) stays ignored. SIGXFSZ, of a limit of
// file size, does nothing: the write that went beyond the limit fails, and is told as any other. Call it once.
void install_interrupt_handler();

// Throws Interrupted once a signal has come. Cheap, and safe from any thread.
void throw_if_interrupted();

// While one lives, the first SIGINT asks for an early end, by made(), and does nothing else; what comes after it is as
// without. One at a time.
class EndRequest {
 public:
  EndRequest();
  ~EndRequest();
  EndRequest(const EndRequest&) = delete;
  EndRequest& operator=(const EndRequest&) = delete;
  [[nodiscard]] bool made() const;
};

// Ends the program by the signal itself, so that the shell sees what happened (a script's loop then stops too).
[[noreturn]] void die_of(const Interrupted& interrupted);

}  // namespace lumatlas
