// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/packed_arrays.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

namespace lumatlas {

namespace {

const char* name_of(PackedCoding coding) {
  switch (coding) {
    case PackedCoding::difference:
      return "difference";
    case PackedCoding::corners:
      return "corners";
    case PackedCoding::plain:
      break;
  }
  return "plain";
}

std::uint32_t alternating(std::uint32_t difference) {
  const auto sign = static_cast<std::uint32_t>(static_cast<std::int32_t>(difference) >> 31);
  return difference << 1 ^ sign;
}

std::vector<std::uint32_t> differences(std::span<const std::uint32_t> values, std::size_t components) {
  std::vector<std::uint32_t> coded(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    coded[i] = alternating(values[i] - (i < components ? 0 : values[i - components]));
  }
  return coded;
}

std::vector<std::uint32_t> below_next(std::span<const std::uint32_t> values) {
  std::vector<std::uint32_t> coded;
  coded.reserve(values.size());
  std::uint32_t next = 0;
  for (const std::uint32_t value : values) {
    if (value > next) throw std::invalid_argument("packed arrays: corners must be numbered as they first come");
    coded.push_back(next - value);
    if (value == next) ++next;
  }
  return coded;
}

std::vector<std::uint32_t> coded(std::span<const std::uint32_t> values, std::size_t components, PackedCoding coding) {
  switch (coding) {
    case PackedCoding::difference:
      return differences(values, components);
    case PackedCoding::corners:
      return below_next(values);
    case PackedCoding::plain:
      break;
  }
  return {values.begin(), values.end()};
}

}  // namespace

void PackedArrays::add(const std::string& name, std::span<const std::uint32_t> values, std::uint32_t components,
                       PackedCoding coding) {
  if (components == 0 || values.size() % components != 0) {
    throw std::invalid_argument("packed arrays: " + name + " has " + std::to_string(values.size()) +
                                " values, which are no whole entries of " + std::to_string(components));
  }
  const std::vector<std::uint32_t> written = coded(values, components, coding);
  const std::uint32_t most = written.empty() ? 0 : *std::max_element(written.begin(), written.end());
  const std::uint32_t planes = (static_cast<std::uint32_t>(std::bit_width(most)) + 7) / 8;
  description_.push_back({{"name", name},
                          {"components", components},
                          {"entries", values.size() / components},
                          {"coding", name_of(coding)},
                          {"bytes", planes}});
  bytes_.reserve(bytes_.size() + planes * written.size());
  for (std::uint32_t component = 0; component < components; ++component) {
    for (std::uint32_t plane = 0; plane < planes; ++plane) {
      for (std::size_t i = component; i < written.size(); i += components) {
        bytes_.push_back(static_cast<std::uint8_t>(written[i] >> (8 * plane)));
      }
    }
  }
}

std::vector<std::uint8_t> PackedArrays::deflated(DeflateEffort effort) const {
  return lumatlas::deflated(bytes_, effort);
}

std::vector<std::uint8_t> deflated(std::span<const std::uint8_t> bytes, DeflateEffort effort) {
  z_stream stream{};
  if (deflateInit(&stream, static_cast<int>(effort)) != Z_OK) throw std::runtime_error("zlib cannot start");
  std::vector<std::uint8_t> result;
  std::vector<std::uint8_t> buffer(1 << 16);
  // zlib counts in 32 bits, arrays do not.
  std::size_t given = 0;
  int status = Z_OK;
  do {
    if (stream.avail_in == 0 && given < bytes.size()) {
      const std::size_t part = std::min<std::size_t>(bytes.size() - given, 1 << 30);
      stream.next_in = const_cast<Bytef*>(&bytes[given]);  // zlib only reads it
      stream.avail_in = static_cast<uInt>(part);
      given += part;
    }
    stream.next_out = buffer.data();
    stream.avail_out = static_cast<uInt>(buffer.size());
    status = deflate(&stream, given == bytes.size() ? Z_FINISH : Z_NO_FLUSH);
    result.insert(result.end(), buffer.begin(), buffer.end() - stream.avail_out);
  } while (status == Z_OK);
  deflateEnd(&stream);
  if (status != Z_STREAM_END)
    throw std::runtime_error("zlib cannot deflate " + std::to_string(bytes.size()) + " bytes");
  return result;
}

}  // namespace lumatlas
