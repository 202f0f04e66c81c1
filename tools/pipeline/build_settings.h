// SPDX-License-Identifier: GPL-3.0-or-later
// The settings of a build: those of tools/settings/ that it uses, and those of BuildOptions itself.
#pragma once

#include "tools/pipeline/build_options.h"
#include "tools/settings/setting.h"

namespace lumatlas {

[[nodiscard]] Settings<BuildOptions> build_settings();

}  // namespace lumatlas
