// SPDX-License-Identifier: GPL-3.0-or-later
// A table of settings for each option struct of the libraries and of the rooms below: setting.h has what a table is.
// Each stands in a file of its own, and its names follow the struct's fields. Structs of rooms further up have their
// tables there: tools/pipeline/build_settings.h, tools/picture/tour_settings.h,
// tools/lab/timing/frame_size_settings.h.
//
// A field without a row is one that commands have an option for, that holds another struct, or that is for callers
// alone; tests/tools/settings names each of them.
#pragma once

#include "atlas/tiles/tiles.h"
#include "atlas/views/validity.h"
#include "blend/blend_options.h"
#include "mesh/cells/cells.h"
#include "planner/planner.h"
#include "tools/meshing/scene_mesh.h"
#include "tools/settings/setting.h"
#include "tools/texture/textured_mesh.h"

namespace lumatlas {

[[nodiscard]] Settings<CellOptions> cell_settings();              // cells.
[[nodiscard]] Settings<CoverageOptions> coverage_settings();      // coverage., but coverage.metric
[[nodiscard]] Settings<CoverageDepartures> departure_settings();  // departures.
[[nodiscard]] Settings<ValidityOptions> mask_settings();          // masks.
[[nodiscard]] Settings<AlignmentOptions> alignment_settings();    // alignment.
[[nodiscard]] Settings<TrustOptions> trust_settings();            // trust.
[[nodiscard]] Settings<RefinementOptions> refinement_settings();  // refinement.
// planner., and those of the structs in it. coverage.metric is among them: the printed measure has gains of its own.
[[nodiscard]] Settings<PlannerOptions> planner_settings();
[[nodiscard]] Settings<TileOptions> tile_settings();        // tiles., but tiles.texels
[[nodiscard]] Settings<BlendOptions> blend_settings();      // blend.
[[nodiscard]] Settings<CutOptions> cut_settings();          // cut.
[[nodiscard]] Settings<SceneMeshOptions> mesh_settings();   // mesh. and cut.
[[nodiscard]] Settings<ColorOptions> color_settings();      // color.
[[nodiscard]] Settings<ChartOptions> chart_settings();      // charts.
[[nodiscard]] Settings<TextureOptions> texture_settings();  // texture., color. and charts.

}  // namespace lumatlas
