// SPDX-License-Identifier: GPL-3.0-or-later
// Plots of sweeps as SVG, drawn by the program gnuplot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/lab/sweep/results.h"

namespace lumatlas {

// Returns the script for gnuplot: one column a scene with figures, one row for each of the plot's y. Colours are those
// of Okabe and Ito (2008), which the colour-blind tell apart; a default is drawn thick, the paper's method dashed and
// hollow, so that they differ without colour too. Empty if no point has both of its figures.
[[nodiscard]] std::string plot_script(const Sweep& sweep, const SweepPlot& plot, const std::vector<Curve>& curves,
                                      const std::filesystem::path& svg);

// Runs gnuplot on the script; `svg` is the file that the script names, and appears complete or not at all. Throws
// InputError with what gnuplot says.
void draw_plot(const std::filesystem::path& gnuplot, const std::string& script, const std::filesystem::path& svg);

// Returns the width, in pixels, at which a file that gnuplot wrote is meant to be shown.
[[nodiscard]] int plot_width(const std::string& svg);

// The <svg> element of a file that gnuplot wrote, for a page with others: its names of parts begin with `prefix`, and
// it scales with the page.
[[nodiscard]] std::string inline_svg(std::string svg, const std::string& prefix);

}  // namespace lumatlas
