// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/float_image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/base/errors.h"
#include "mesh/base/number_text.h"
#include "mesh/base/whole_file.h"

namespace lumatlas {

namespace {

void check(const FloatImage& image) {
  constexpr std::uint32_t kMaxSide = 65536;    // pixels; also the largest camera
  constexpr std::size_t kMostNameBytes = 255;  // that OpenEXR can hold
  const auto fits = [](std::uint32_t side) { return side >= 1 && side <= kMaxSide; };
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

std::string one_line(std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason.empty() ? reason : " (" + reason + ")";
}

}  // namespace

void write_float_image(const std::filesystem::path& path, const FloatImage& image) {
  check(image);
  if (path.extension() != ".exr")
    throw std::invalid_argument("float image: " + path.string() + " does not end in .exr");
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output) throw InputError(path.string() + ": this build of OpenImageIO cannot write OpenEXR");
  output->threads(1);
  OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                       static_cast<int>(image.channels.size()), OIIO::TypeDesc::FLOAT);
  spec.channelnames = image.channels;
  spec.attribute("compression", "zip");
  // Into memory, because not every write that fails is told by the writer for files.
  std::vector<unsigned char> bytes;
  OIIO::Filesystem::IOVecOutput memory(bytes);
  OIIO::Filesystem::IOProxy* proxy = &memory;
  spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &proxy);
  if (!output->open(path.string(), spec) || !output->write_image(OIIO::TypeDesc::FLOAT, image.values.data()) ||
      !output->close()) {
    throw InputError(path.string() + ": cannot be written" + one_line(output->geterror()));
  }
  write_whole_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()}, Durability::left_to_folder);
}

}  // namespace lumatlas
