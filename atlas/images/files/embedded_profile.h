// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: finds the ICC profiles in PNG and TIFF files and hides them from OpenImageIO. Version 2.4 decodes
// the texts of a profile while it opens a file, and ends the program at some damaged ones.
#pragma once

#include <OpenImageIO/filesystem.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace lumatlas {

// A file, or bytes in memory, that OpenImageIO reads with other bytes in some places.
class PatchedReader : public OIIO::Filesystem::IOProxy {
 public:
  // `file` is open for reading.
  explicit PatchedReader(std::unique_ptr<OIIO::Filesystem::IOProxy> file);

  // Replaces what is read from `offset` on, bytes from the start of the file, by `bytes`.
  void patch(std::uint64_t offset, std::vector<std::uint8_t> bytes);

  [[nodiscard]] const char* proxytype() const override;
  [[nodiscard]] std::int64_t tell() override;
  bool seek(std::int64_t offset) override;
  std::size_t read(void* buffer, std::size_t size) override;
  std::size_t pread(void* buffer, std::size_t size, std::int64_t offset) override;
  [[nodiscard]] std::size_t size() const override;

 private:
  struct Patch {
    std::uint64_t offset;  // bytes from the start of the file
    std::vector<std::uint8_t> bytes;
  };
  void apply(std::uint8_t* buffer, std::size_t size, std::uint64_t offset) const;

  std::unique_ptr<OIIO::Filesystem::IOProxy> file_;
  std::vector<Patch> patches_;
};

// Hides all profiles before the pixels of a PNG file, or in the first directory of a TIFF file. Returns the first
// profile, at most 8 MiB; empty: there is none, or none that can be unpacked. A profile may hold any bytes, and the
// file may be damaged anywhere.
[[nodiscard]] std::vector<std::uint8_t> hide_png_profile(PatchedReader& file);
[[nodiscard]] std::vector<std::uint8_t> hide_tiff_profile(PatchedReader& file);

// Returns the profile of a WebP file, as above. It need not be hidden: OpenImageIO 2.4 passes over it.
[[nodiscard]] std::vector<std::uint8_t> webp_profile(PatchedReader& file);

}  // namespace lumatlas
