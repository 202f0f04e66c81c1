// SPDX-License-Identifier: GPL-3.0-or-later
// Writes pictures into files that are there whole or not at all.
#include <filesystem>

#include "atlas/images/float_image.h"
#include "atlas/images/image_code.h"
#include "atlas/images/photograph.h"
#include "mesh/base/pending_file.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

void write_picture(const std::filesystem::path& path, const std::vector<std::uint8_t>& bytes) {
  write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, Durability::left_to_folder);
}

}  // namespace

void write_image(const std::filesystem::path& path, const Photograph& image, std::span<const std::uint8_t> alpha) {
  if (can_be_encoded_in_memory(path)) {
    write_picture(path, encode_as_named(path, image, alpha));
    return;
  }
  PendingFile file(path);
  encode_to_file(file.path(), path, image, alpha);
  file.commit(Durability::left_to_folder);
}

void write_float_image(const std::filesystem::path& path, const FloatImage& image) {
  write_picture(path, encode_openexr(path, image));
}

}  // namespace lumatlas
