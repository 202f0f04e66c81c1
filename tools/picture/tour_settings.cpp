// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/picture/tour_settings.h"

#include "tools/picture/paths/camera_tours.h"

namespace lumatlas {

Settings<TourOptions> tour_settings() {
  return {whole_setting("hilbert-order", &TourOptions::hilbert_order, "N", whole_number_rule(1, kMostHilbertOrder),
                        "With --hilbert, the curve has 2^N turns a side"),
          switch_setting("anywhere", &TourOptions::anywhere,
                         "Lay --orbit and --hilbert also past what was not photographed, rather than near the "
                         "photographs")};
}

}  // namespace lumatlas
