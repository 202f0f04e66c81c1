// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how much better pictures become if surface is added where the mesh has none.
//
// Small photographs are predicted without themselves. Where they see the surface, their prediction is the mean colour
// of the same points in the other photographs that are nearest in direction; elsewhere it is the fill that pictures
// have there (tools/frame/background.h). The gain is the growth of the PSNR over whole frames, averaged over the
// photographs. So it is small where little is lacking, where the fill is nearly right, and where poses or exposures
// make larger errors on the surface than the fill makes beside it.
#pragma once

#include <optional>
#include <vector>

#include "mesh/visibility/visibility.h"
#include "tools/pipeline/surface/far_background.h"

namespace lumatlas {

// Returns the gain if all pixels that see neither the mesh nor the far sphere were predicted exactly, in dB, >= 0: the
// most that added surface can bring. `far`: null if there is no far sphere. None: no two photographs show the same
// point of the mesh.
[[nodiscard]] std::optional<double> largest_gain_db(const std::vector<SmallPhotograph>& photographs,
                                                    const Visibility& given, const Visibility* far);

// Returns the gain of a completed mesh over the given one, in dB; below 0 if it makes pictures worse. Pixels whose
// added surface no other photograph shows count as filled. `far`: that of the given mesh. None as largest_gain_db().
[[nodiscard]] std::optional<double> completion_gain_db(const std::vector<SmallPhotograph>& photographs,
                                                       const Visibility& given, const Visibility* far,
                                                       const Visibility& completed);

}  // namespace lumatlas
