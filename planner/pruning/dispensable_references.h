// SPDX-License-Identifier: GPL-3.0-or-later
// Finds the references that cells can do without, and predicts the loss: see predicted_loss.h.
#pragma once

#include <cstdint>
#include <vector>

#include "planner/coverage/coverage_ledger.h"

namespace lumatlas {

// Returns the sum of CoverageLedger::reference_service() over all cells.
[[nodiscard]] ReferenceService reference_service(const CoverageLedger& ledger);

// Returns the share of the service of all references, those that were given up among them, that is missing once the
// kept ones lose `lost` more; in [0, 1].
[[nodiscard]] double reference_gap(const ReferenceService& service, double lost);

// Returns, by cell, the slots that it can do without as long as all of them together are predicted to cost at most
// `max_loss_db`, dB of fitted PSNR; none unless that is above 0. What a cell loses grows from one reference to the
// next, so the cells' own orders, merged by loss, are the best order of all.
[[nodiscard]] std::vector<std::vector<ViewSlot>> dispensable_references(const CoverageLedger& ledger,
                                                                        double max_loss_db);

}  // namespace lumatlas
