// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a solution for all views at once beyond which its equations are solved step by step.
#pragma once

#include <cstddef>

namespace lumatlas {

// Operations on tiles of 98 x 98 that a factor may take for one step: those of 490 views and lenses where all share
// points, which are 1.2 seconds of one core on x86-64 without AVX. Beyond, conjugate gradients solve the equations
// (conjugate_gradients.h), which take less time then. Each operation is 98^3 multiplications at most. A solution has 20
// to 40 steps. Along a walk, where each view shares points with the 40 before it, 1600 views take 1,700 operations and
// 0.2 seconds.
inline constexpr std::size_t kMostStepOperations = 8'000;

}  // namespace lumatlas
