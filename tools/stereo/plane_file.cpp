// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/stereo/plane_file.h"

#include <array>
#include <cstring>
#include <fstream>
#include <span>
#include <vector>

#include "atlas/model/content_digest.h"
#include "tools/base/output_folder.h"

namespace lumatlas {
namespace {

constexpr std::uint64_t kFormat = 0x31454E414C504D4CU;  // "LMPLANE1"
constexpr std::uint32_t kMostPixels = 1U << 28U;

struct Header {
  std::uint64_t format = kFormat;
  std::uint64_t inputs = 0;
  std::uint64_t content = 0;  // digest of planes and costs
  std::uint32_t width = 0, height = 0;
};

std::uint64_t digest_of(const PlaneMap& map) {
  const std::array<std::uint64_t, 2> both{content_digest(std::as_bytes(std::span(map.planes))),
                                          content_digest(std::as_bytes(std::span(map.costs)))};
  return content_digest(std::as_bytes(std::span(both)));
}

}  // namespace

void write_planes(const std::filesystem::path& file, std::uint64_t inputs, const PlaneMap& map) {
  const Header header{kFormat, inputs, digest_of(map), map.width, map.height};
  AtomicFile output(file);
  const auto write = [&](const void* data, std::size_t bytes) {
    output.stream().write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
  };
  write(&header, sizeof header);
  write(map.planes.data(), map.planes.size() * sizeof(SlantedPlane));
  write(map.costs.data(), map.costs.size() * sizeof(float));
  output.commit();
}

std::optional<PlaneMap> read_planes(const std::filesystem::path& file, std::uint64_t inputs) {
  std::ifstream input(file, std::ios::binary);
  const auto read = [&](void* data, std::size_t bytes) {
    input.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes));
    return static_cast<std::size_t>(input.gcount()) == bytes;
  };
  Header header;
  if (!input || !read(&header, sizeof header) || header.format != kFormat || header.inputs != inputs) {
    return std::nullopt;
  }
  if (header.width == 0 || header.height == 0 || header.height > kMostPixels / header.width) return std::nullopt;
  const std::size_t pixels = std::size_t{header.width} * header.height;
  PlaneMap map{header.width, header.height, std::vector<SlantedPlane>(pixels), std::vector<float>(pixels)};
  if (!read(map.planes.data(), pixels * sizeof(SlantedPlane)) || !read(map.costs.data(), pixels * sizeof(float)) ||
      digest_of(map) != header.content) {
    return std::nullopt;
  }
  return map;
}

}  // namespace lumatlas
