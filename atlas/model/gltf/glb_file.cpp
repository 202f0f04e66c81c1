// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/model/gltf/glb_file.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <limits>
#include <string_view>
#include <system_error>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "glTF";
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;  // "BIN"
constexpr std::uint64_t kHeaderBytes = 12;
constexpr std::uint64_t kChunkHeaderBytes = 8;

[[noreturn]] void refuse(const fs::path& file, const std::string& why) {
  throw InputError(file.string() + ": " + why);
}

// Little-endian, on any machine.
std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

std::string word(std::uint64_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes.push_back(static_cast<char>(value >> (8 * i) & 0xff));
  return bytes;
}

// Chunks begin at multiples of 4 bytes.
std::size_t padding(std::size_t bytes) {
  return (4 - bytes % 4) % 4;
}

std::uint64_t bytes_in_file(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  if (error) refuse(file, "cannot be read (" + error.message() + ")");
  return bytes;
}

class GlbReader {
 public:
  explicit GlbReader(const fs::path& path) : path_(path), file_(path, std::ios::binary), left_(bytes_in_file(path)) {}

  [[nodiscard]] std::uint64_t left() const { return left_; }

  std::string read(std::uint64_t count, const char* what) {
    if (count > left_) {
      refuse(path_, std::string(what) + " has " + std::to_string(count) + " bytes, but only " + std::to_string(left_) +
                        " of the file are left: it is damaged or cut off");
    }
    std::string bytes(count, '\0');
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(count))) refuse(path_, "cannot be read to its end");
    left_ -= count;
    return bytes;
  }

 private:
  const fs::path& path_;
  std::ifstream file_;
  std::uint64_t left_;
};

void check_header(const fs::path& file, std::string_view header, std::uint64_t file_bytes) {
  if (word_at(header, 4) != 2) {
    refuse(file, "is of glTF version " + std::to_string(word_at(header, 4)) + ", this program reads 2.0");
  }
  if (word_at(header, 8) != file_bytes) {
    refuse(file, "has " + std::to_string(file_bytes) + " bytes, its header says " + std::to_string(word_at(header, 8)) +
                     ": it is damaged or cut off");
  }
}

}  // namespace

bool is_glb(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, kMagic.size()> first{};
  return stream.read(first.data(), first.size()) && std::string_view(first.data(), first.size()) == kMagic;
}

GlbFrame read_glb_frame(const fs::path& file) {
  GlbReader reader(file);
  const std::uint64_t file_bytes = reader.left();
  check_header(file, reader.read(kHeaderBytes, "its header"), file_bytes);
  const std::string json_header = reader.read(kChunkHeaderBytes, "the header of its first chunk");
  if (word_at(json_header, 4) != kJsonChunk) refuse(file, "its first chunk is not JSON: it is no glTF 2.0 file");
  GlbFrame frame;
  frame.json = reader.read(word_at(json_header, 0), "its JSON");
  if (reader.left() == 0) return frame;
  const std::string binary_header = reader.read(kChunkHeaderBytes, "the header of its second chunk");
  if (word_at(binary_header, 4) != kBinaryChunk) return frame;  // readers pass over what they do not know
  frame.binary_at = file_bytes - reader.left();
  frame.binary_bytes = word_at(binary_header, 0);
  if (frame.binary_bytes > reader.left()) {
    refuse(file, "its binary chunk has " + std::to_string(frame.binary_bytes) + " bytes, but only " +
                     std::to_string(reader.left()) + " of the file are left: it is damaged or cut off");
  }
  return frame;
}

std::vector<unsigned char> read_glb_binary(const fs::path& file, const GlbFrame& frame, std::uint64_t bytes) {
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(frame.binary_at));
  std::vector<unsigned char> binary(std::min(bytes, frame.binary_bytes));
  if (!stream.read(reinterpret_cast<char*>(binary.data()), static_cast<std::streamsize>(binary.size()))) {
    refuse(file, "cannot be read to its end");
  }
  return binary;
}

void write_glb_frame(std::ostream& file, std::string json, std::span<const unsigned char> binary) {
  json.append(padding(json.size()), ' ');
  const std::string zeros(padding(binary.size()), '\0');
  const std::uint64_t binary_bytes = binary.size() + zeros.size();
  const std::uint64_t bytes = kHeaderBytes + 2 * kChunkHeaderBytes + json.size() + binary_bytes;
  require_fits_glb(bytes);
  file << kMagic << word(2) << word(bytes) << word(json.size()) << word(kJsonChunk) << json << word(binary_bytes)
       << word(kBinaryChunk);
  file.write(reinterpret_cast<const char*>(binary.data()), static_cast<std::streamsize>(binary.size())) << zeros;
}

void require_fits_glb(std::uint64_t bytes) {
  if (bytes <= std::numeric_limits<std::uint32_t>::max()) return;
  throw InputError("the model takes " + std::to_string(bytes) +
                   " bytes, a .glb holds less than 4 GiB: name a folder instead");
}

}  // namespace lumatlas
