// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to mesh/: clusters too small to be worth a cell of their own.
#pragma once

#include <cstdint>
#include <vector>

#include "mesh/cancel_check.h"
#include "mesh/cells/cluster_mesh.h"

namespace lumatlas {

// Gives each cluster much smaller than size^2, smallest first, to a neighbour with which it is still compact and mostly
// faces one way; a cluster without such a neighbour stays. `labels` holds a cluster for each face. Labels below `first`
// may absorb neighbours from `first` on, and are never absorbed.
void merge_slivers(const ClusterMesh& surface, double size, std::vector<std::uint32_t>& labels, std::uint32_t first = 0,
                   const CancelCheck& cancel_check = {});

}  // namespace lumatlas
