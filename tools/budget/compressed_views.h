// SPDX-License-Identifier: GPL-3.0-or-later
// The photographs of a store in compressed texels, where the pictures lose little by it.
#pragma once

#include <optional>

#include "atlas/atlas.h"
#include "atlas/tiles/tiles.h"
#include "mesh/visibility/visibility.h"
#include "tools/budget/held_out_loss.h"
#include "tools/budget/measured_loss.h"

namespace lumatlas {

// Cuts the stored views by `compressed` if the pictures lose at most this many dB by measurement, with references given
// up too (see HeldOutLoss). Returns the loss, only as exactly as it took to decide. None: they stay as they are.
// `measured` must be able to tell. Throws GlError as it does; nothing was changed then. No other thread may change the
// atlas or ask for its layout meanwhile.
[[nodiscard]] std::optional<MeasuredLoss> compress_views_within(double max_loss_db, double reference_loss_db,
                                                                const TileOptions& compressed, Atlas& atlas,
                                                                HeldOutLoss& measured, const Visibility& visibility);

}  // namespace lumatlas
