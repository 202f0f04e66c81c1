// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the frame of a .glb, glTF's single binary file: a header of 12 bytes, a chunk of JSON, a binary
// chunk; glTF 2.0, section 4.4.
#pragma once

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

namespace lumatlas {

// Returns whether a file is a .glb by its first bytes, whatever its name. False if it cannot be read.
[[nodiscard]] bool is_glb(const std::filesystem::path& file);

struct GlbFrame {
  std::string json;
  std::uint64_t binary_at = 0;     // bytes from the beginning of the file
  std::uint64_t binary_bytes = 0;  // 0: it has no binary chunk
};

// Everything but the binary chunk. Throws InputError: file, what is wrong with its lengths.
[[nodiscard]] GlbFrame read_glb_frame(const std::filesystem::path& file);

// The first `bytes` of the binary chunk, which has as many. Throws InputError.
[[nodiscard]] std::vector<unsigned char> read_glb_binary(const std::filesystem::path& file, const GlbFrame& frame,
                                                         std::uint64_t bytes);

// The caller checks whether the stream has failed. Throws InputError by require_fits_glb() before anything is written.
void write_glb_frame(std::ostream& file, std::string json, std::span<const unsigned char> binary);

// A .glb has 32 bits for its length. Throws InputError, one sentence without a path, for more `bytes`.
void require_fits_glb(std::uint64_t bytes);

}  // namespace lumatlas
