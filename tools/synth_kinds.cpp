// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/synth_kinds.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace lumatlas {

namespace {

constexpr std::array kKinds{
    SynthKindRow{SynthKind::apartment, "apartment", "two furnished rooms with glossy floors", synth::make_apartment},
};

}  // namespace

std::span<const SynthKindRow> synth_kinds() {
  return kKinds;
}

const SynthKindRow& synth_kind(SynthKind kind) {
  const auto* const row =
      std::find_if(kKinds.begin(), kKinds.end(), [&](const SynthKindRow& candidate) { return candidate.kind == kind; });
  if (row == kKinds.end()) throw std::invalid_argument("synth: kind is not one of its enumerators");
  return *row;
}

SynthKind synth_kind_named(std::string_view name) {
  std::string names;
  for (const SynthKindRow& row : kKinds) {
    if (name == row.name) return row.kind;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  throw std::invalid_argument("synth: kind is " + std::string(name) + ", must be one of " + names);
}

namespace synth {

Scene make_scene(const SynthOptions& options) {
  check(options);
  return synth_kind(options.kind).make(options.seed, options.triangles);
}

}  // namespace synth

}  // namespace lumatlas
