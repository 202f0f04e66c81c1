// SPDX-License-Identifier: GPL-3.0-or-later
// report.css and report.js, which the report's page holds within itself.
#pragma once

namespace lumatlas {

extern const char* const kReportStyle;
extern const char* const kReportScript;

}  // namespace lumatlas
