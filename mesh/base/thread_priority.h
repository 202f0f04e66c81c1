// SPDX-License-Identifier: GPL-3.0-or-later
// Lets threads that work in the background give way to those that a person waits for.
#pragma once

namespace lumatlas {

// Lowers the priority of the calling thread by 5 steps of `nice`, for as long as the thread lives: only a privileged
// process may raise it again. A thread that competes with it for a core then gets about three quarters of that core.
// Does nothing where threads have no priority of their own, which is everywhere but on Linux.
void lower_thread_priority() noexcept;

}  // namespace lumatlas
