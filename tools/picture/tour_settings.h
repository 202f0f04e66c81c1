// SPDX-License-Identifier: GPL-3.0-or-later
// The settings of camera paths: path.
#pragma once

#include "tools/picture/model_tour.h"
#include "tools/settings/setting.h"

namespace lumatlas {

[[nodiscard]] Settings<TourOptions> tour_settings();

}  // namespace lumatlas
