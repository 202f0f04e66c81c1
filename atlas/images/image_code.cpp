// SPDX-License-Identifier: GPL-3.0-or-later
// The one function that the shared library of image code exports.
#include "atlas/images/image_code.h"

#include "atlas/images/lower_resolution.h"

namespace {

constexpr lumatlas::ImageCode kImageCode{
    LUMATLAS_VERSION,
    lumatlas::photograph_size,
    lumatlas::photograph_size,
    lumatlas::read_camera_note,
    lumatlas::read_photograph,
    lumatlas::read_photograph,
    lumatlas::read_photograph_rows,
    lumatlas::read_photograph_rows,
    lumatlas::read_alpha,
    lumatlas::read_grey_image,
    lumatlas::encode_image,
    lumatlas::encode_grey_image,
    lumatlas::can_be_encoded_in_memory,
    lumatlas::encode_as_named,
    lumatlas::encode_to_file,
    lumatlas::encode_openexr,
    lumatlas::at_lower_resolution,
    lumatlas::mask_at_lower_resolution,
};

}  // namespace

extern "C" [[gnu::visibility("default")]] const lumatlas::ImageCode* lumatlas_image_code() {
  return &kImageCode;
}
