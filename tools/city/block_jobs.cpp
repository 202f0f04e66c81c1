// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/block_jobs.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "tools/base/process/child_process.h"
#include "tools/base/process/interrupt.h"
#include "tools/city/block_job.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::string last_line(const fs::path& log) {
  std::ifstream file(log);
  std::string line, last;
  while (std::getline(file, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

// Takes numbers of blocks from a list, and runs their jobs until the list is empty.
class Worker {
 public:
  // `threads`: number of threads that each job uses, >= 1.
  Worker(const fs::path& program, const fs::path& folder, const std::vector<std::size_t>& blocks, std::size_t threads,
         std::atomic<std::size_t>& next)
      : program_(program), folder_(folder), blocks_(blocks), threads_(threads), next_(next) {}

  // Appends what failed. `done` is called after each job.
  template <typename Done>
  void run(std::vector<FailedBlock>& failed, std::mutex& mutex, const Done& done) const {
    for (std::size_t place = next_++; place < blocks_.size(); place = next_++) {
      std::optional<FailedBlock> failure = run_one(blocks_[place]);
      const std::lock_guard lock(mutex);
      if (failure) failed.push_back(std::move(*failure));
      done();
    }
  }

 private:
  [[nodiscard]] std::optional<FailedBlock> run_one(std::size_t block) const {
    const fs::path log = block_log(folder_, block);
    const int status = run_to_end(
        {program_,
         {"city", folder_.string(), "--job", std::to_string(block), "--threads", std::to_string(threads_), "--quiet"},
         log,
         log});
    if (status == 0) return std::nullopt;
    const std::string said = last_line(log);
    const std::string ended =
        status < 0 ? "was ended by signal " + std::to_string(-status) : "ended with status " + std::to_string(status);
    return FailedBlock{block, said.empty() || status < 0 ? ended : said};
  }

  const fs::path& program_;
  const fs::path& folder_;
  const std::vector<std::size_t>& blocks_;
  std::size_t threads_;
  std::atomic<std::size_t>& next_;
};

}  // namespace

std::vector<FailedBlock> run_block_jobs(const fs::path& program, const fs::path& folder, const CityPlan& plan,
                                        std::size_t jobs, const BuildCallback& callback) {
  std::vector<std::size_t> blocks;
  for (std::size_t block = 0; block < plan.blocks.size(); ++block) {
    if (!is_block_done(folder, plan, block)) blocks.push_back(block);
  }
  fs::create_directories(block_log(folder, 0).parent_path());
  BuildStage stage(callback, "building blocks", blocks.size());
  std::atomic<std::size_t> next{0};
  std::mutex mutex;  // guards the rest
  std::vector<FailedBlock> failed;
  std::exception_ptr thrown;
  std::size_t done = 0, running = 0;
  const std::size_t at_once = std::min(std::max<std::size_t>(jobs, 1), blocks.size());
  const std::size_t processors = std::max(1u, std::thread::hardware_concurrency());
  const Worker worker(program, folder, blocks, std::max<std::size_t>(1, processors / std::max<std::size_t>(1, at_once)),
                      next);
  std::vector<std::jthread> threads;
  for (std::size_t i = 0; i < at_once; ++i) {
    ++running;
    threads.emplace_back([&] {
      std::exception_ptr error;
      try {
        worker.run(failed, mutex, [&] { ++done; });
      } catch (...) {
        error = std::current_exception();
        next = blocks.size();  // no other job begins
      }
      const std::lock_guard lock(mutex);
      if (error && !thrown) thrown = error;
      --running;
    });
  }
  // Progress is told on the caller's thread, which the callback expects.
  for (std::size_t told = 0;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::unique_lock lock(mutex);
    const bool ended = running == 0;
    const std::size_t now = done;
    lock.unlock();
    for (; told < now; ++told) stage.tick();
    if (ended) break;
  }
  threads.clear();
  if (thrown) std::rethrow_exception(thrown);
  throw_if_interrupted();
  stage.finish();
  std::sort(failed.begin(), failed.end(), [](const auto& a, const auto& b) { return a.block < b.block; });
  return failed;
}

}  // namespace lumatlas
