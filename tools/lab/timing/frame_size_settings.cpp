// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/lab/timing/frame_size_settings.h"

namespace lumatlas {

Settings<FrameSize> frame_size_settings() {
  return {whole_setting("width", &FrameSize::width, "PX", whole_number_rule(1, 65536),
                        "With --time-frames, width of the frames"),
          whole_setting("height", &FrameSize::height, "PX", whole_number_rule(1, 65536),
                        "With --time-frames, height of the frames")};
}

}  // namespace lumatlas
