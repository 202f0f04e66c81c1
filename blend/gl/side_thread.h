// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: a thread beside the one that draws, for calls that cannot be cut into pieces. It allocates large
// objects of OpenGL, whose memory drivers in software clear, and frees memory.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

#include "blend/gl/egl_context.h"

namespace lumatlas {

// The thread that draws calls all functions, with the context current that it draws in. The other thread starts with
// the first call.
class SideThread {
 public:
  SideThread() = default;
  // Waits for all that was asked of the thread.
  ~SideThread();
  SideThread(const SideThread&) = delete;
  SideThread& operator=(const SideThread&) = delete;

  // Returns whether the thread has a context that shares its objects with the one that draws; none as long as that is
  // not known. The first call makes the context. See EglContext::sharing_with_current().
  [[nodiscard]] std::optional<bool> has_context();
  // Calls `make` on the thread, which must have a context. Its objects may be used in both contexts once the result is
  // there; `make` must leave none of them bound. The result holds what `make` throws.
  template <typename Make>
  [[nodiscard]] std::future<std::invoke_result_t<Make>> make(Make make) {
    const auto task = std::make_shared<std::packaged_task<std::invoke_result_t<Make>()>>([make = std::move(make)] {
      auto made = make();
      finish();
      return made;
    });
    auto result = task->get_future();
    add([task] { (*task)(); });
    return result;
  }

  // Returns whether make() may be called.
  [[nodiscard]] bool makes_objects() const { return state_ == ContextState::current; }

  // Frees what nothing else refers to.
  void free_later(std::shared_ptr<const void> memory);
  // Frees textures and buffers that the context that draws has no use of any more; at once unless the thread has a
  // context.
  void free_objects(std::shared_ptr<const void> objects) {
    if (makes_objects()) free_later(std::move(objects));
  }

 private:
  using Task = std::function<void()>;
  enum class ContextState { none, starting, current };

  void ask_for_context();
  [[nodiscard]] bool start();
  void add(Task task);
  void work();
  static void finish();

  ContextState state_ = ContextState::none;
  bool asked_for_context_ = false;
  std::optional<EglContext> context_;
  std::optional<CurrentContext> current_;  // of the thread
  std::future<bool> is_current_;           // while the context is starting
  std::mutex mutex_;
  std::condition_variable added_;
  std::deque<Task> tasks_;  // guarded by the mutex
  bool ended_ = false;      // guarded by the mutex
  std::thread thread_;
};

}  // namespace lumatlas
