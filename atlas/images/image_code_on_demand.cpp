// SPDX-License-Identifier: GPL-3.0-or-later
// Calls the functions of image_code.h in the shared library that holds them, which the first call opens.
#include "atlas/images/image_code.h"

#include <dlfcn.h>

#include <string>

#include "atlas/images/lower_resolution.h"
#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& reason) {
  throw InputError(std::string(LUMATLAS_IMAGES_FILE) + ", which reads and writes images, " + reason +
                   ": install lumatlas anew");
}

// The system looks for the library beside the program, where it was installed and where it was built (the run path of
// whatever this code is linked into). It stays open, because its libraries may have threads.
const ImageCode& opened_image_code() {
  void* const library = dlopen(LUMATLAS_IMAGES_FILE, RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* const reason = dlerror();
    fail(std::string("cannot be opened (") + (reason == nullptr ? "no reason given" : reason) + ")");
  }
  void* const symbol = dlsym(library, kImageCodeFunction);
  if (symbol == nullptr) fail("is another library of this name");
  const ImageCode* const code = reinterpret_cast<ImageCodeFunction>(symbol)();
  if (code->version != std::string(LUMATLAS_VERSION)) {
    fail(std::string("is of version ") + code->version + ", this is " + LUMATLAS_VERSION);
  }
  return *code;
}

const ImageCode& image_code() {
  static const ImageCode& code = opened_image_code();
  return code;
}

}  // namespace

ImageSize photograph_size(const fs::path& path, Orientation orientation) {
  return image_code().size_of_file(path, orientation);
}

ImageSize photograph_size(std::span<const std::uint8_t> file, const std::string& name) {
  return image_code().size_of_bytes(file, name);
}

CameraNote read_camera_note(const fs::path& path) {
  return image_code().read_camera_note(path);
}

Photograph read_photograph(const fs::path& path, Orientation orientation) {
  return image_code().read_file(path, orientation);
}

Photograph read_photograph(std::span<const std::uint8_t> file, const std::string& name) {
  return image_code().read_bytes(file, name);
}

ImageSize read_photograph_rows(const fs::path& path, const PixelRows& use) {
  return image_code().read_rows_of_file(path, use);
}

ImageSize read_photograph_rows(std::span<const std::uint8_t> file, const std::string& name, const PixelRows& use) {
  return image_code().read_rows_of_bytes(file, name, use);
}

std::vector<std::uint8_t> read_alpha(const fs::path& path, Orientation orientation) {
  return image_code().read_alpha(path, orientation);
}

GreyImage read_grey_image(const fs::path& path) {
  return image_code().read_grey_image(path);
}

std::vector<std::uint8_t> encode_image(const Photograph& image, const ImageCoding& coding,
                                       const std::optional<CameraNote>& note) {
  return image_code().encode_image(image, coding, note);
}

bool can_be_encoded_in_memory(const fs::path& path) {
  return image_code().can_be_encoded_in_memory(path);
}

std::vector<std::uint8_t> encode_grey_image(const GreyImage& image) {
  return image_code().encode_grey_image(image);
}

std::vector<std::uint8_t> encode_as_named(const fs::path& path, const Photograph& image,
                                          std::span<const std::uint8_t> alpha) {
  return image_code().encode_as_named(path, image, alpha);
}

void encode_to_file(const fs::path& file, const fs::path& path, const Photograph& image,
                    std::span<const std::uint8_t> alpha) {
  image_code().encode_to_file(file, path, image, alpha);
}

std::vector<std::uint8_t> encode_openexr(const fs::path& path, const FloatImage& image) {
  return image_code().encode_openexr(path, image);
}

Photograph at_lower_resolution(const Photograph& photograph, std::uint32_t width, std::uint32_t height) {
  return image_code().at_lower_resolution(photograph, width, height);
}

std::vector<std::uint8_t> mask_at_lower_resolution(std::span<const std::uint8_t> mask, ImageSize from, ImageSize to) {
  return image_code().mask_at_lower_resolution(mask, from, to);
}

}  // namespace lumatlas
