// SPDX-License-Identifier: GPL-3.0-or-later
// The memory that photographs and masks of stored views take in this process, and the scratch files that take the
// rest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

namespace lumatlas {

// The bytes of all PixelBuffers of this process. Those below kLeastBoundBytes are always in memory and do not count.
struct PixelMemory {
  std::uint64_t in_memory = 0;
  std::uint64_t in_files = 0;  // in scratch files
};
[[nodiscard]] PixelMemory pixel_memory();

inline constexpr std::size_t kLeastBoundBytes = std::size_t{64} << 10;

// Bounds PixelMemory::in_memory while it lives. A PixelBuffer that is made beyond the bound lies in a scratch file,
// which has no name and is gone with the buffer, or with the process. The system reads it page by page. No value
// depends on the bound. Where several bounds live, the one that was made last counts. Safe from any thread.
class PixelMemoryBound {
 public:
  // `folder` takes the scratch files. Throws InputError unless it is a folder.
  PixelMemoryBound(std::uint64_t bytes, std::filesystem::path folder);
  ~PixelMemoryBound();
  PixelMemoryBound(const PixelMemoryBound&) = delete;
  PixelMemoryBound& operator=(const PixelMemoryBound&) = delete;
};

// Gives pages of scratch files that this process has read back to the system, if they, and the other files that it
// maps, take more than half of the bound in its memory. Does nothing without a bound. Takes some microseconds, and up
// to a microsecond for each scratch file if there are pages to give back. Call it between steps that read photographs.
void give_back_scratch_pages();

// Returns half of the memory that the system can give to a process now, at least 256 MiB; bytes. Where the system does
// not say how much that is, returns the largest number.
[[nodiscard]] std::uint64_t usual_pixel_memory();

// Internal to PixelBuffer. Counts bytes in memory as long as it lives.
class PixelMemoryShare {
 public:
  PixelMemoryShare() = default;
  explicit PixelMemoryShare(std::size_t bytes);  // which have been taken
  PixelMemoryShare(PixelMemoryShare&& other) noexcept;
  PixelMemoryShare& operator=(PixelMemoryShare&& other) noexcept;
  ~PixelMemoryShare();
  // Counts the bytes if they fit within the bound, and returns whether they do.
  [[nodiscard]] static bool take(std::size_t bytes);

 private:
  std::size_t bytes_ = 0;
};

// Internal to PixelBuffer. Holds bytes in a scratch file that is mapped into memory.
class ScratchFile {
 public:
  // Writes the bytes, of which there is at least one, to the folder of the newest bound. Throws InputError, naming the
  // folder, if it does not take them.
  explicit ScratchFile(std::span<const std::byte> bytes);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  [[nodiscard]] const std::byte* data() const { return data_; }
  [[nodiscard]] std::size_t size() const { return size_; }
  void give_back_pages() const;

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_;
};

}  // namespace lumatlas
