// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/side_thread.h"

#include <epoxy/gl.h>

#include <chrono>
#include <system_error>

#include "mesh/base/thread_priority.h"

namespace lumatlas {

SideThread::~SideThread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  added_.notify_one();
  thread_.join();
}

std::optional<bool> SideThread::has_context() {
  if (!std::exchange(asked_for_context_, true)) ask_for_context();
  if (state_ == ContextState::starting) {
    if (is_current_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    state_ = is_current_.get() ? ContextState::current : ContextState::none;
  }
  return state_ == ContextState::current;
}

// Makes a context and asks the thread to make it current. The renderer draws without it too, so that any failure means
// that there is none.
void SideThread::ask_for_context() {
  try {
    context_ = EglContext::sharing_with_current();
    if (!context_ || !start()) return;
    const auto task = std::make_shared<std::packaged_task<bool()>>([this] {
      try {
        current_.emplace(*context_);
        return true;
      } catch (...) {
        return false;
      }
    });
    is_current_ = task->get_future();
    add([task] { (*task)(); });
    state_ = ContextState::starting;
  } catch (...) {  // state_ stays `none`
  }
}

void SideThread::finish() {
  glFinish();
}

void SideThread::free_later(std::shared_ptr<const void> memory) {
  if (start()) add([memory = std::move(memory)]() mutable { memory.reset(); });
}

// Returns whether the thread is there.
bool SideThread::start() {
  if (thread_.joinable()) return true;
  try {
    thread_ = std::thread([this] { work(); });
    return true;
  } catch (const std::system_error&) {  // the system has no more threads
    return false;
  }
}

void SideThread::add(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  added_.notify_one();
}

void SideThread::work() {
  lower_thread_priority();
  std::unique_lock lock(mutex_);
  while (true) {
    added_.wait(lock, [&] { return ended_ || !tasks_.empty(); });
    if (tasks_.empty()) break;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    task = nullptr;  // which frees memory
    lock.lock();
  }
  lock.unlock();
  current_.reset();
}

}  // namespace lumatlas
