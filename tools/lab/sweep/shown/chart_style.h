// SPDX-License-Identifier: GPL-3.0-or-later
// chart.css, which the page of charts holds within itself.
#pragma once

namespace lumatlas {

extern const char* const kChartStyle;

}  // namespace lumatlas
