// SPDX-License-Identifier: GPL-3.0-or-later
#include "planner/exchange.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace lumatlas {

namespace {

// Those views leave together that are worth least for their size, as many as it takes.
Exchange joint_exchange(const PlannedStore& store, std::span<const CellPart> parts, std::uint64_t bytes) {
  std::vector<ViewSlot> slots = store.held_slots();
  const auto density = [&](ViewSlot slot) {
    return store.ledger().loss(slot) / static_cast<double>(std::max<std::uint64_t>(store.bytes_of(slot), 1));
  };
  std::sort(slots.begin(), slots.end(),
            [&](ViewSlot a, ViewSlot b) { return std::pair(density(a), a) < std::pair(density(b), b); });
  Exchange exchange;
  std::uint64_t freed = 0;
  while (!store.fits(bytes, freed, static_cast<std::uint32_t>(exchange.victims.size()))) {
    exchange.victims.push_back(slots[exchange.victims.size()]);
    freed += store.bytes_of(exchange.victims.back());
  }
  // A large one that came late may make room enough without some that came before it.
  for (std::size_t i = exchange.victims.size(); i-- > 0;) {
    const std::uint64_t less = freed - store.bytes_of(exchange.victims[i]);
    if (!store.fits(bytes, less, static_cast<std::uint32_t>(exchange.victims.size() - 1))) continue;
    freed = less;
    exchange.victims.erase(exchange.victims.begin() + static_cast<std::ptrdiff_t>(i));
  }
  exchange.gain = store.ledger().joint_exchange_gain(parts, exchange.victims);
  return exchange;
}

}  // namespace

Exchange best_exchange(const PlannedStore& store, std::span<const CellPart> parts, std::uint64_t bytes) {
  if (store.fits(bytes)) return {{}, store.ledger().gain(parts)};
  std::vector<ViewSlot> candidates = store.held_slots();
  std::erase_if(candidates, [&](ViewSlot slot) { return !store.fits(bytes, store.bytes_of(slot), 1); });
  if (candidates.empty()) return joint_exchange(store, parts, bytes);
  const bool each_makes_room = candidates.size() == store.held_views();
  const std::uint32_t most = store.options().victims;
  if (most > 0) candidates = missed_least(store.ledger(), std::move(candidates), most);
  const std::vector<double> gains = store.ledger().exchange_gains(parts, candidates);
  const auto best = std::max_element(gains.begin(), gains.end());
  Exchange single{{candidates[static_cast<std::size_t>(best - gains.begin())]}, *best};
  if (each_makes_room) return single;
  Exchange joint = joint_exchange(store, parts, bytes);  // small views may be worth less together than a large one
  return joint.gain > single.gain ? joint : single;
}

}  // namespace lumatlas
