// SPDX-License-Identifier: GPL-3.0-or-later
// Encodes pictures by OpenImageIO, into memory wherever the form allows that: its writers for files do not all tell of
// writes that failed.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "atlas/images/image_code.h"
#include "atlas/images/image_errors.h"
#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"

namespace lumatlas {

namespace {

using OIIO::TypeDesc;
using Output = std::unique_ptr<OIIO::ImageOutput>;

void check_picture(const Photograph& image, std::span<const std::uint8_t> alpha = {}) {
  const std::size_t expected = std::size_t{3} * image.width * image.height;
  if (expected == 0 || image.width > kLongestImageSide || image.height > kLongestImageSide) {
    throw std::invalid_argument("image size is " + size_text(image.width, image.height) +
                                "; each side must be in [1, 65536]");
  }
  if (image.rgb.size() != expected) {
    throw std::invalid_argument("image.rgb has " + std::to_string(image.rgb.size()) + " bytes; it must have " +
                                std::to_string(expected) + " (3 * width * height)");
  }
  if (!alpha.empty() && 3 * alpha.size() != expected) {
    throw std::invalid_argument("image: there are " + std::to_string(alpha.size()) +
                                " alphas, must be one for each of " + size_text(image.width, image.height) + " pixels");
  }
}

void check_picture(const GreyImage& image) {
  const std::size_t expected = std::size_t{image.width} * image.height;
  if (expected > 0 && image.width <= kLongestImageSide && image.height <= kLongestImageSide &&
      image.values.size() == expected) {
    return;
  }
  throw std::invalid_argument("grey image: " + std::to_string(image.values.size()) + " values for a size of " +
                              size_text(image.width, image.height) + "; each side must be in [1, 65536]");
}

void check_picture(const FloatImage& image) {
  constexpr std::size_t kMostNameBytes = 255;  // that OpenEXR can hold
  const auto fits = [](std::uint32_t side) { return side >= 1 && side <= std::uint32_t{kLongestImageSide}; };
  if (!fits(image.width) || !fits(image.height)) {
    throw std::invalid_argument("float image: size is " + size_text(image.width, image.height) +
                                "; each side must be in [1, 65536]");
  }
  const std::size_t expected = std::size_t{image.width} * image.height * image.channels.size();
  if (image.channels.empty()) throw std::invalid_argument("float image: it has no channels");
  for (std::size_t i = 0; i < image.channels.size(); ++i) {
    const std::string& name = image.channels[i];
    const bool is_new =
        std::find(image.channels.begin(), image.channels.begin() + i, name) == image.channels.begin() + i;
    if (is_new && !name.empty() && name.size() <= kMostNameBytes && name.find('\0') == std::string::npos) continue;
    throw std::invalid_argument("float image: the name of channel " + std::to_string(i) + " is '" + name +
                                "', must have 1 to 255 bytes, none of them 0, and be another than those before");
  }
  if (image.values.size() != expected) {
    throw std::invalid_argument("float image: has " + std::to_string(image.values.size()) + " values, must have " +
                                std::to_string(expected));
  }
}

float linear_of(std::uint8_t byte) {
  const float encoded = static_cast<float>(byte) / 255.0f;
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

std::vector<std::uint8_t> with_alpha(const Photograph& image, std::span<const std::uint8_t> alpha) {
  std::vector<std::uint8_t> rgba(4 * alpha.size());
  for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel) {
    std::copy_n(&image.rgb[3 * pixel], 3, &rgba[4 * pixel]);
    rgba[4 * pixel + 3] = alpha[pixel];
  }
  return rgba;
}

// Formats that hold numbers instead of codes get linear light, as read_photograph() expects of them.
bool write_pixels(OIIO::ImageOutput& output, const Photograph& image, std::span<const std::uint8_t> alpha = {}) {
  const std::vector<std::uint8_t> rgba = with_alpha(image, alpha);
  const std::span<const std::uint8_t> codes(alpha.empty() ? image.rgb : rgba);
  if (!output.spec().format.is_floating_point()) return output.write_image(TypeDesc::UINT8, codes.data());
  std::vector<float> linear(codes.size());
  std::transform(codes.begin(), codes.end(), linear.begin(), linear_of);
  for (std::size_t pixel = 0; pixel < alpha.size(); ++pixel) {
    linear[4 * pixel + 3] = static_cast<float>(alpha[pixel]) / 255.0f;
  }
  return output.write_image(TypeDesc::FLOAT, linear.data());
}

OIIO::ImageSpec spec_of(const Photograph& image, std::span<const std::uint8_t> alpha = {}) {
  const int channels = alpha.empty() ? 3 : 4;
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), channels, TypeDesc::UINT8);
  // Six times as fast as the defaults on photographs, and no larger.
  spec.attribute("png:compressionLevel", 1);
  spec.attribute("png:filter", 0x20);  // "up", PNG_FILTER_UP
  if (!alpha.empty()) spec.attribute("oiio:UnassociatedAlpha", 1);
  return spec;
}

void set_gps_angle(OIIO::ImageSpec& spec, const std::string& name, double degrees, const char* positive,
                   const char* negative) {
  const double whole = std::floor(std::abs(degrees)), minutes = (std::abs(degrees) - whole) * 60;
  const std::array parts{static_cast<float>(whole), static_cast<float>(std::floor(minutes)),
                         static_cast<float>((minutes - std::floor(minutes)) * 60)};
  spec.attribute(name, TypeDesc(TypeDesc::FLOAT, 3), parts.data());
  spec.attribute(name + "Ref", degrees < 0 ? negative : positive);
}

void set_camera_note(OIIO::ImageSpec& spec, const CameraNote& note) {
  if (!note.make.empty()) spec.attribute("Make", note.make);
  if (!note.model.empty()) spec.attribute("Model", note.model);
  if (note.focal_length_mm > 0) spec.attribute("Exif:FocalLength", static_cast<float>(note.focal_length_mm));
  if (note.focal_length_35mm > 0) {
    spec.attribute("Exif:FocalLengthIn35mmFilm", static_cast<int>(std::lround(note.focal_length_35mm)));
  }
  if (!note.gps) return;
  set_gps_angle(spec, "GPS:Latitude", note.gps->latitude_deg, "N", "S");
  set_gps_angle(spec, "GPS:Longitude", note.gps->longitude_deg, "E", "W");
  spec.attribute("GPS:Altitude", static_cast<float>(std::abs(note.gps->altitude_m)));
  spec.attribute("GPS:AltitudeRef", note.gps->altitude_m < 0 ? 1 : 0);
}

// Returns nothing where OpenImageIO knows no form by the ending of the name.
Output output_named(const std::string& name) {
  Output output = OIIO::ImageOutput::create(name);
  if (!output) {
    (void)OIIO::geterror();  // an error that is not fetched would be printed at exit
    return nullptr;
  }
  output->threads(1);
  return output;
}

Output output_for_file(const std::filesystem::path& path) {
  Output output = output_named(path.string());
  if (output) return output;
  throw InputError(path.string() + ": no image format is known by the ending '" + path.extension().string() +
                   "'; use .png or .jpg");
}

// Opens, writes by `write(output)` and closes; returns the file's bytes. The name tells the form. Where that fails,
// throws InputError with `complaint` and the writer's reason.
template <typename Write>
std::vector<std::uint8_t> encoded(OIIO::ImageOutput& output, const std::string& name, OIIO::ImageSpec spec,
                                  const std::string& complaint, const Write& write) {
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  OIIO::Filesystem::IOProxy* proxy = &memory;
  spec.attribute("oiio:ioproxy", TypeDesc::PTR, &proxy);
  if (!output.open(name, spec) || !write(output) || !output.close() || bytes.empty()) {
    throw InputError(complaint + because(output.geterror()));
  }
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> encode_image(const Photograph& image, const ImageCoding& coding,
                                       const std::optional<CameraNote>& note) {
  check_picture(image);
  check(coding);
  const std::string name = std::string("image") + ending(coding.format);
  const Output output = output_named(name);
  if (!output) throw InputError(name + ": OpenImageIO is installed without this format");
  OIIO::ImageSpec spec = spec_of(image);
  if (coding.format == ImageFormat::webp) {
    spec.attribute("compression", "webp:" + std::to_string(coding.quality));
  } else {
    spec.attribute("CompressionQuality", coding.quality);
    spec.attribute("jpeg:subsampling", "4:4:4");
  }
  if (note) set_camera_note(spec, *note);
  return encoded(*output, name, spec, name + ": cannot be encoded",
                 [&](OIIO::ImageOutput& opened) { return write_pixels(opened, image); });
}

std::vector<std::uint8_t> encode_grey_image(const GreyImage& image) {
  check_picture(image);
  const std::string name = "image.png";
  const Output output = output_named(name);
  if (!output) throw InputError(name + ": OpenImageIO is installed without this format");
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 1, TypeDesc::UINT16);
  spec.attribute("png:compressionLevel", 1);
  return encoded(*output, name, spec, name + ": cannot be encoded",
                 [&](OIIO::ImageOutput& opened) { return opened.write_image(TypeDesc::UINT16, image.values.data()); });
}

bool can_be_encoded_in_memory(const std::filesystem::path& path) {
  return output_for_file(path)->supports("ioproxy") != 0;
}

std::vector<std::uint8_t> encode_as_named(const std::filesystem::path& path, const Photograph& image,
                                          std::span<const std::uint8_t> alpha) {
  check_picture(image, alpha);
  const Output output = output_for_file(path);
  return encoded(*output, path.string(), spec_of(image, alpha), path.string() + ": cannot be written",
                 [&](OIIO::ImageOutput& opened) { return write_pixels(opened, image, alpha); });
}

void encode_to_file(const std::filesystem::path& file, const std::filesystem::path& path, const Photograph& image,
                    std::span<const std::uint8_t> alpha) {
  check_picture(image, alpha);
  const Output output = output_for_file(path);
  if (output->open(file.string(), spec_of(image, alpha)) && write_pixels(*output, image, alpha) && output->close()) {
    return;
  }
  throw InputError(path.string() + ": cannot be written" + because(output->geterror()));
}

std::vector<std::uint8_t> encode_openexr(const std::filesystem::path& path, const FloatImage& image) {
  check_picture(image);
  if (path.extension() != ".exr")
    throw std::invalid_argument("float image: " + path.string() + " does not end in .exr");
  const Output output = output_named(path.string());
  if (!output) throw InputError(path.string() + ": this build of OpenImageIO cannot write OpenEXR");
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                       static_cast<int>(image.channels.size()), TypeDesc::FLOAT);
  spec.channelnames = image.channels;
  spec.attribute("compression", "zip");
  return encoded(*output, path.string(), spec, path.string() + ": cannot be written",
                 [&](OIIO::ImageOutput& opened) { return opened.write_image(TypeDesc::FLOAT, image.values.data()); });
}

}  // namespace lumatlas
