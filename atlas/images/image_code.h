// SPDX-License-Identifier: GPL-3.0-or-later
// The functions that read, write and resize images by OpenImageIO, LibRaw and libheif. These libraries bring some 260
// others along, whose loading takes longer than many commands do. So these functions are built as a shared library of
// their own, lumatlas-images, which is opened when the first of them is called (image_code_on_demand.cpp). A sanitized
// build links them as any other: a library that is opened later would escape the sanitizer's start.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "atlas/images/float_image.h"
#include "atlas/images/photograph.h"

namespace lumatlas {

// For write_image(). `path` tells the form by its ending, and stands for the picture in sentences. These throw
// InputError for an ending that names no form, and where the picture cannot be encoded.
[[nodiscard]] bool can_be_encoded_in_memory(const std::filesystem::path& path);
[[nodiscard]] std::vector<std::uint8_t> encode_as_named(const std::filesystem::path& path, const Photograph& image,
                                                        std::span<const std::uint8_t> alpha);
// Writes the file itself, which has the ending of `path`, for forms that cannot be encoded in memory.
void encode_to_file(const std::filesystem::path& file, const std::filesystem::path& path, const Photograph& image,
                    std::span<const std::uint8_t> alpha);

// For write_float_image(): the bytes of an OpenEXR file.
[[nodiscard]] std::vector<std::uint8_t> encode_openexr(const std::filesystem::path& path, const FloatImage& image);

// The table that lumatlas-images exports. Its functions are those of the same names in photograph.h, lower_resolution.h
// and this header.
struct ImageCode {
  const char* version;  // lumatlas's version
  ImageSize (*size_of_file)(const std::filesystem::path&, Orientation);
  ImageSize (*size_of_bytes)(std::span<const std::uint8_t>, const std::string&);
  CameraNote (*read_camera_note)(const std::filesystem::path&);
  Photograph (*read_file)(const std::filesystem::path&, Orientation);
  Photograph (*read_bytes)(std::span<const std::uint8_t>, const std::string&);
  ImageSize (*read_rows_of_file)(const std::filesystem::path&, const PixelRows&);
  ImageSize (*read_rows_of_bytes)(std::span<const std::uint8_t>, const std::string&, const PixelRows&);
  std::vector<std::uint8_t> (*read_alpha)(const std::filesystem::path&, Orientation);
  GreyImage (*read_grey_image)(const std::filesystem::path&);
  std::vector<std::uint8_t> (*encode_image)(const Photograph&, const ImageCoding&, const std::optional<CameraNote>&);
  std::vector<std::uint8_t> (*encode_grey_image)(const GreyImage&);
  bool (*can_be_encoded_in_memory)(const std::filesystem::path&);
  std::vector<std::uint8_t> (*encode_as_named)(const std::filesystem::path&, const Photograph&,
                                               std::span<const std::uint8_t>);
  void (*encode_to_file)(const std::filesystem::path&, const std::filesystem::path&, const Photograph&,
                         std::span<const std::uint8_t>);
  std::vector<std::uint8_t> (*encode_openexr)(const std::filesystem::path&, const FloatImage&);
  Photograph (*at_lower_resolution)(const Photograph&, std::uint32_t, std::uint32_t);
  std::vector<std::uint8_t> (*mask_at_lower_resolution)(std::span<const std::uint8_t>, ImageSize, ImageSize);
};

// The name of the one function that the shared library exports, and its type.
inline constexpr const char* kImageCodeFunction = "lumatlas_image_code";
using ImageCodeFunction = const ImageCode* (*)();

}  // namespace lumatlas
