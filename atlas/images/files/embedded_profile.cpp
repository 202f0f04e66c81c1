// SPDX-License-Identifier: GPL-3.0-or-later
// W3C PNG, third edition, 11.3.2.3: iCCP. TIFF 6.0, section 2: directories;
// BigTIFF as libtiff reads it. RFC 9649 (WebP), section 2.7.1.4: ICCP. ICC.1:2010, B.4: the tag of a profile.
#include "atlas/images/files/embedded_profile.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

namespace lumatlas {

namespace {

constexpr std::size_t kMostProfileBytes = 8 << 20;  // libpng's limit

// Returns nothing if the file ends before.
std::optional<std::vector<std::uint8_t>> bytes_at(PatchedReader& file, std::uint64_t offset, std::uint64_t size) {
  if (offset > file.size() || size > file.size() - offset) return std::nullopt;
  std::vector<std::uint8_t> bytes(size);
  if (file.pread(bytes.data(), bytes.size(), static_cast<std::int64_t>(offset)) != size) return std::nullopt;
  return bytes;
}

std::uint64_t big_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

std::uint64_t little_endian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = count; i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

// Returns what is unpacked before the end or the first damage. Empty if that is more than a profile may have.
std::vector<std::uint8_t> inflated(const std::uint8_t* data, std::size_t size) {
  z_stream stream{};
  if (inflateInit(&stream) != Z_OK) return {};
  stream.next_in = const_cast<Bytef*>(data);
  stream.avail_in = static_cast<uInt>(size);
  std::vector<std::uint8_t> result;
  std::array<std::uint8_t, 1 << 14> block;
  int status = Z_OK;
  while (status == Z_OK && result.size() <= kMostProfileBytes) {
    stream.next_out = block.data();
    stream.avail_out = static_cast<uInt>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    result.insert(result.end(), block.begin(), block.end() - stream.avail_out);
  }
  inflateEnd(&stream);
  return result.size() > kMostProfileBytes ? std::vector<std::uint8_t>() : result;
}

// `chunk` is the data of an iCCP chunk: a name, a zero, the method 0, and what is packed.
std::vector<std::uint8_t> unpacked_profile(const std::vector<std::uint8_t>& chunk) {
  const auto end_of_name = std::find(chunk.begin(), chunk.end(), 0);
  const auto before = static_cast<std::size_t>(end_of_name - chunk.begin()) + 2;
  return chunk.size() <= before ? std::vector<std::uint8_t>() : inflated(chunk.data() + before, chunk.size() - before);
}

// The offset of a TIFF file's first directory, and how the file writes numbers.
struct TiffLayout {
  bool is_big_endian, is_big_tiff;

  [[nodiscard]] std::uint64_t number(const std::uint8_t* bytes, int count) const {
    return is_big_endian ? big_endian(bytes, count) : little_endian(bytes, count);
  }
  [[nodiscard]] int word() const { return is_big_tiff ? 8 : 4; }  // bytes of an offset, and of a value in an entry
  [[nodiscard]] std::uint64_t entry_bytes() const { return is_big_tiff ? 20 : 12; }
  [[nodiscard]] int count_bytes() const { return is_big_tiff ? 8 : 2; }  // bytes that hold the number of entries
};

// The bytes that an entry points to. Empty unless they are bytes, and as many as a profile may have.
std::vector<std::uint8_t> pointed_bytes(PatchedReader& file, const TiffLayout& layout, const std::uint8_t* entry) {
  constexpr std::uint64_t kByte = 1, kUndefined = 7;
  const std::uint64_t type = layout.number(entry + 2, 2);
  const std::uint64_t count = layout.number(entry + 4, layout.word());
  if ((type != kByte && type != kUndefined) || count > kMostProfileBytes) return {};
  return bytes_at(file, layout.number(entry + 4 + layout.word(), layout.word()), count)
      .value_or(std::vector<std::uint8_t>());
}

}  // namespace

PatchedReader::PatchedReader(std::unique_ptr<OIIO::Filesystem::IOProxy> file)
    : IOProxy(file->filename(), Read), file_(std::move(file)) {}

void PatchedReader::patch(std::uint64_t offset, std::vector<std::uint8_t> bytes) {
  patches_.push_back({offset, std::move(bytes)});
}

const char* PatchedReader::proxytype() const {
  return "patched";
}

std::int64_t PatchedReader::tell() {
  return file_->tell();
}

bool PatchedReader::seek(std::int64_t offset) {
  return file_->seek(offset);
}

std::size_t PatchedReader::read(void* buffer, std::size_t size) {
  const std::int64_t offset = file_->tell();
  const std::size_t count = file_->read(buffer, size);
  apply(static_cast<std::uint8_t*>(buffer), count, static_cast<std::uint64_t>(offset));
  return count;
}

std::size_t PatchedReader::pread(void* buffer, std::size_t size, std::int64_t offset) {
  const std::size_t count = file_->pread(buffer, size, offset);
  apply(static_cast<std::uint8_t*>(buffer), count, static_cast<std::uint64_t>(offset));
  return count;
}

std::size_t PatchedReader::size() const {
  return file_->size();
}

void PatchedReader::apply(std::uint8_t* buffer, std::size_t size, std::uint64_t offset) const {
  for (const Patch& patch : patches_) {
    const std::uint64_t begin = std::max(offset, patch.offset);
    const std::uint64_t end = std::min(offset + size, patch.offset + patch.bytes.size());
    if (begin < end) std::memcpy(buffer + (begin - offset), patch.bytes.data() + (begin - patch.offset), end - begin);
  }
}

std::vector<std::uint8_t> hide_png_profile(PatchedReader& file) {
  constexpr std::array<std::uint8_t, 4> kHiddenType{'i', 'c', 'C', 'P'};  // unknown to readers, which skip it
  std::optional<std::vector<std::uint8_t>> profile;
  for (std::uint64_t at = 8; const auto head = bytes_at(file, at, 8);) {
    const std::uint64_t length = big_endian(head->data(), 4);
    if (std::memcmp(head->data() + 4, "IDAT", 4) == 0) break;
    if (std::memcmp(head->data() + 4, "iCCP", 4) == 0) {
      const auto data = bytes_at(file, at + 8, length);
      if (!data) break;
      if (!profile) profile = unpacked_profile(*data);
      const uLong sum = crc32_z(crc32(0, kHiddenType.data(), kHiddenType.size()), data->data(), data->size());
      file.patch(at + 4, {kHiddenType.begin(), kHiddenType.end()});
      file.patch(at + 8 + length, {static_cast<std::uint8_t>(sum >> 24), static_cast<std::uint8_t>(sum >> 16),
                                   static_cast<std::uint8_t>(sum >> 8), static_cast<std::uint8_t>(sum)});
    }
    at += 12 + length;
  }
  return profile.value_or(std::vector<std::uint8_t>());
}

std::vector<std::uint8_t> hide_tiff_profile(PatchedReader& file) {
  constexpr std::uint64_t kProfileTag = 34675, kHiddenTag = 34676;  // nothing is known by the other number
  constexpr std::uint64_t kMostEntries = 65535;                     // libtiff takes no more than 4096
  const auto head = bytes_at(file, 0, 8);
  if (!head) return {};
  TiffLayout layout{(*head)[0] == 'M', false};
  layout.is_big_tiff = layout.number(head->data() + 2, 2) == 43;
  const auto offset = bytes_at(file, layout.is_big_tiff ? 8 : 4, layout.word());
  if (!offset) return {};
  const std::uint64_t directory = layout.number(offset->data(), layout.word());
  const auto count = bytes_at(file, directory, layout.count_bytes());
  if (!count) return {};
  const std::uint64_t entries = std::min(layout.number(count->data(), layout.count_bytes()), kMostEntries);
  std::optional<std::vector<std::uint8_t>> profile;
  for (std::uint64_t i = 0; i < entries; ++i) {
    const std::uint64_t at = directory + layout.count_bytes() + i * layout.entry_bytes();
    const auto entry = bytes_at(file, at, layout.entry_bytes());
    if (!entry) break;
    if (layout.number(entry->data(), 2) != kProfileTag) continue;
    if (!profile) profile = pointed_bytes(file, layout, entry->data());
    const auto low = static_cast<std::uint8_t>(kHiddenTag & 0xff), high = static_cast<std::uint8_t>(kHiddenTag >> 8);
    file.patch(at, layout.is_big_endian ? std::vector{high, low} : std::vector{low, high});
  }
  return profile.value_or(std::vector<std::uint8_t>());
}

std::vector<std::uint8_t> webp_profile(PatchedReader& file) {
  constexpr std::uint64_t kMostChunks = 64;  // the profile stands before the pixels
  std::uint64_t at = 12;                     // "RIFF", a length, "WEBP"
  for (std::uint64_t i = 0; i < kMostChunks; ++i) {
    const auto head = bytes_at(file, at, 8);
    if (!head) return {};
    const std::uint64_t size = little_endian(head->data() + 4, 4);
    if (std::memcmp(head->data(), "ICCP", 4) == 0) {
      return size > kMostProfileBytes ? std::vector<std::uint8_t>()
                                      : bytes_at(file, at + 8, size).value_or(std::vector<std::uint8_t>());
    }
    at += 8 + size + size % 2;
  }
  return {};
}

}  // namespace lumatlas
