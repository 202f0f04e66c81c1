// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/next_snapshot.h"

#include <utility>

#include "blend/tables/snapshot_preparation.h"

namespace lumatlas {

NextSnapshot::NextSnapshot(std::shared_ptr<SnapshotPreparation> preparation) : preparation_(std::move(preparation)) {}

void NextSnapshot::prepare() {
  const std::shared_ptr<SnapshotPreparation> kept = preparation_;  // this object may become another's meanwhile
  kept->run();
}

void NextSnapshot::cancel() {
  preparation_->cancel();
}

std::uint64_t NextSnapshot::waiting_bytes() const {
  return preparation_->waiting_bytes();
}

}  // namespace lumatlas
