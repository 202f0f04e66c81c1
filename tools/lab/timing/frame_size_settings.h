// SPDX-License-Identifier: GPL-3.0-or-later
// The settings of the frames that are timed: timing.
#pragma once

#include "tools/lab/timing/frame_time.h"
#include "tools/settings/setting.h"

namespace lumatlas {

[[nodiscard]] Settings<FrameSize> frame_size_settings();

}  // namespace lumatlas
