// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/process_limits.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <climits>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace lumatlas {

namespace {

constexpr rlim_t kLeastStack = rlim_t{1} << 20;  // bytes: trees over meshes are built by functions that recurse

std::string complaint_about(int resource, rlim_t least, const char* name, const char* option) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY || limit.rlim_cur >= least) return "";
  const std::string kilobytes = std::to_string(least >> 10);
  return std::string("the limit of ") + name + " is " + std::to_string(limit.rlim_cur >> 10) +
         " KiB, lumatlas needs at least " + kilobytes + ": raise it (`ulimit " + option + " " + kilobytes + "`)";
}

// Threads that wait until this object goes.
class WaitingThreads {
 public:
  ~WaitingThreads() {
    {
      const std::lock_guard lock(mutex_);
      may_end_ = true;
    }
    ended_.notify_all();
    for (const pthread_t thread : threads_) pthread_join(thread, nullptr);
  }
  WaitingThreads() = default;
  WaitingThreads(const WaitingThreads&) = delete;
  WaitingThreads& operator=(const WaitingThreads&) = delete;

  // False where the system gives no more.
  [[nodiscard]] bool start(std::size_t count) {
    // Bytes. They do next to nothing, but what is local to a thread has its place there too: CGAL has 32 KiB for each
    // kind of triangulation.
    constexpr std::size_t kStack = 256 << 10;
    threads_.reserve(count);
    pthread_attr_t attributes;
    pthread_attr_init(&attributes);
    pthread_attr_setstacksize(&attributes, std::max<std::size_t>(kStack, static_cast<std::size_t>(PTHREAD_STACK_MIN)));
    while (threads_.size() < count) {
      pthread_t thread{};
      if (pthread_create(&thread, &attributes, wait, this) != 0) break;
      threads_.push_back(thread);
    }
    pthread_attr_destroy(&attributes);
    return threads_.size() == count;
  }
  [[nodiscard]] std::size_t started() const { return threads_.size(); }

 private:
  static void* wait(void* object) {
    auto& self = *static_cast<WaitingThreads*>(object);
    std::unique_lock lock(self.mutex_);
    self.ended_.wait(lock, [&] { return self.may_end_; });
    return nullptr;
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  bool may_end_ = false;
  std::vector<pthread_t> threads_;
};

std::string complaint_about_threads() {
  // The planner, the photographs' reader and the driver each start as many as there are cores, and some.
  const std::size_t count = 3 * std::size_t{std::max(1u, std::thread::hardware_concurrency())} + 4;
  WaitingThreads threads;
  if (threads.start(count)) return "";
  return "only " + std::to_string(threads.started()) + " threads can be started, lumatlas needs " +
         std::to_string(count) + " on this machine: raise the limit of processes (`ulimit -u`, --pids-limit of a " +
         "container), or stop some";
}

}  // namespace

std::string complaint_about_limits(std::uint64_t least_address_space) {
  std::string complaint = complaint_about(RLIMIT_AS, least_address_space, "memory", "-v");
  if (complaint.empty()) complaint = complaint_about(RLIMIT_STACK, kLeastStack, "the stack", "-s");
  return complaint.empty() ? complaint_about_threads() : complaint;
}

std::string why_not_written() {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return "is the disk full?";
  return "is the disk full, or the limit of file size (`ulimit -f`, " + std::to_string(limit.rlim_cur >> 10) +
         " KiB) too low?";
}

}  // namespace lumatlas
