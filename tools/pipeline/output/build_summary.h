// SPDX-License-Identifier: GPL-3.0-or-later
// The summary of a build, for scripts and for people.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/pipeline/build_model.h"

namespace lumatlas {

// Returns the JSON that `build --json` prints. Beside the counts:
//   references_per_cell  how many cells refer to 0, 1, 2 ... views, up to the most that any cell refers to
//   cells_full           cells with as many references as they may have
//   bytes                what the stored views take, as planner/planner.h counts it, and what they may take; the budget
//                        is null if nothing bounds it
//   parsimony            of --budget auto, else null: the bound, what is lost, and what of that was measured, dB; the
//                        gap of coverage; the views taken away once the stream had ended; views, references and
//                        texels, stored and of all offered views
//   texture              of the base texture, null without one: its side, texels; its charts; texels for a photograph's
//                        pixel along a side; the time that it took
//   time_ms.per_view     of each stage, over the views that it was done for, and how many they are
[[nodiscard]] nlohmann::json summary(const BuildResult& result, const BuildOptions& options);

// Returns the summary as a few lines of text; `name` is the model's.
[[nodiscard]] std::string summary_text(const nlohmann::json& summary, const std::string& name);

// One line of the "parsimony" above, which must not be null.
[[nodiscard]] std::string parsimony_text(const nlohmann::json& parsimony);

// One line of "frames", {"surface", "added", "far", "filled"}: by what the photographs' frames are filled, in shares of
// their pixels.
[[nodiscard]] std::string frames_text(const nlohmann::json& frames);

// Returns the "trust" of the summary as a line of text.
[[nodiscard]] std::string trust_text(const nlohmann::json& trust);

// Returns how many cells refer to 0, 1, 2 ... views, up to the most that any cell refers to.
[[nodiscard]] std::vector<std::size_t> cells_by_references(const ReferenceTable& references);

// The options as they were used, for the file beside the output; "settings" has those of build_settings().
[[nodiscard]] nlohmann::json effective_options(const BuildResult& result, const BuildOptions& options);

// One entry per offered view, in the order of the stream: its decision, gain and times, and scov afterwards.
[[nodiscard]] nlohmann::json plan_json(const BuildResult& result);

}  // namespace lumatlas
