// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/fields/brown_lens.h"

#include <algorithm>
#include <initializer_list>

namespace lumatlas {

namespace {

LensModel simplest_model(const BrownLens& b) {
  const bool only_brown = b.p3 != 0 || b.p4 != 0 || b.skew != 0;
  if (b.fisheye) return only_brown ? LensModel::kBrownFisheye : LensModel::kThinPrismFisheye;
  if (only_brown || b.k4 != 0) return LensModel::kBrown;
  if (b.k3 != 0) return LensModel::kFullOpenCv;
  const bool distorted = b.k1 != 0 || b.k2 != 0 || b.p1 != 0 || b.p2 != 0;
  return distorted ? LensModel::kOpenCv : LensModel::kPinhole;
}

}  // namespace

CameraModel lens_of(const BrownLens& b) {
  CameraModel lens{simplest_model(b), b.width, b.height, {b.fx, b.fy, b.cx, b.cy}};
  const auto set = [&](std::initializer_list<double> coefficients) {
    std::copy(coefficients.begin(), coefficients.end(), lens.parameters.begin() + 4);
  };
  if (lens.model == LensModel::kBrown || lens.model == LensModel::kBrownFisheye) {
    set({b.skew / b.fx, b.k1, b.k2, b.k3, b.k4, b.p1, b.p2, b.p3, b.p4});
  } else if (lens.model == LensModel::kThinPrismFisheye) {
    set({b.k1, b.k2, b.p1, b.p2, b.k3, b.k4, 0, 0});
  } else if (lens.model == LensModel::kFullOpenCv) {
    set({b.k1, b.k2, b.p1, b.p2, b.k3, 0, 0, 0});
  } else if (lens.model == LensModel::kOpenCv) {
    set({b.k1, b.k2, b.p1, b.p2});
  }
  check(lens);
  return lens;
}

}  // namespace lumatlas
