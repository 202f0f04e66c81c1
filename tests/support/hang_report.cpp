// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/hang_report.h"

#include <execinfo.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::atomic<int> stack_output{-1};
std::atomic<int> stacks_written{0};

// In the thread whose stack it is. backtrace() has loaded what it needs before, so that it takes no memory here.
void write_own_stack(int /*signal*/) {
  const int error = errno;
  std::array<void*, 64> frames{};
  const int count = backtrace(frames.data(), static_cast<int>(frames.size()));
  backtrace_symbols_fd(frames.data(), count, stack_output.load());
  ++stacks_written;
  errno = error;
}

void write_text(int descriptor, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t written = write(descriptor, text.data() + done, text.size() - done);
    if (written < 0) return;
    done += static_cast<std::size_t>(written);
  }
}

// The names in a folder of /proc that are numbers.
std::vector<pid_t> numbers_in(const fs::path& folder) {
  std::vector<pid_t> numbers;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    if (std::all_of(name.begin(), name.end(), [](char c) { return c >= '0' && c <= '9'; })) {
      numbers.push_back(std::stoi(name));
    }
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  std::replace(text.begin(), text.end(), '\0', ' ');
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return text;
}

// /proc/PID/stat: the number, the name in parentheses, the state, and the parent's number.
std::pair<char, pid_t> state_and_parent(pid_t process) {
  const std::string stat = text_of("/proc/" + std::to_string(process) + "/stat");
  const std::size_t name_end = stat.rfind(')');
  if (name_end == std::string::npos || name_end + 4 >= stat.size()) return {'?', 0};
  return {stat[name_end + 2], std::stoi(stat.substr(name_end + 4))};
}

void write_processes_below(pid_t parent, const std::vector<pid_t>& all, int descriptor) {
  for (const pid_t process : all) {
    const auto [state, its_parent] = state_and_parent(process);
    if (its_parent != parent) continue;
    const std::string folder = "/proc/" + std::to_string(process);
    write_text(descriptor, "process " + std::to_string(process) + " below " + std::to_string(parent) + ", state " +
                               state + ": " + text_of(folder + "/cmdline") + '\n');
    for (const pid_t thread : numbers_in(folder + "/task")) {
      const std::string of_thread = folder + "/task/" + std::to_string(thread);
      write_text(descriptor, "  thread " + std::to_string(thread) + " " + text_of(of_thread + "/comm") +
                                 ": system call " + text_of(of_thread + "/syscall") + '\n');
    }
    write_processes_below(process, all, descriptor);
  }
}

void write_stack_of(pid_t thread, int descriptor) {
  const std::string name = text_of("/proc/self/task/" + std::to_string(thread) + "/comm");
  write_text(descriptor, "thread " + std::to_string(thread) + " " + name + ":\n");
  const int before = stacks_written;
  if (syscall(SYS_tgkill, getpid(), thread, SIGURG) != 0) return;
  for (int wait = 0; wait < 100 && stacks_written == before; ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace

void write_stacks(int descriptor) {
  std::array<void*, 1> frame{};
  (void)backtrace(frame.data(), 1);
  stack_output = descriptor;
  struct sigaction action {
  }, before{};
  action.sa_handler = write_own_stack;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGURG, &action, &before);
  for (const pid_t thread : numbers_in("/proc/self/task")) write_stack_of(thread, descriptor);
  sigaction(SIGURG, &before, nullptr);
  write_processes_below(getpid(), numbers_in("/proc"), descriptor);
}

void report_hang_after(std::chrono::seconds time) {
  std::thread([time] {
    std::this_thread::sleep_for(time);
    write_text(STDERR_FILENO, "this test still runs after " + std::to_string(time.count()) + " s; its threads:\n");
    write_stacks(STDERR_FILENO);
  }).detach();
}

}  // namespace lumatlas
