// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: buffers and tables that are copied to the GPU piece by piece, so that a frame waits for none of
// them. The bytes must stay until all are copied. A driver may clear the memory of a whole buffer or table where it is
// allocated, so that another thread had better allocate a large one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

// Most bytes that one step of an upload copies. A row of a texture may have more, and has at most twice as many.
inline constexpr std::size_t kPieceBytes = 1 << 18;

// Allocates a buffer and leaves it unbound; what it holds is not defined. Throws GlError.
[[nodiscard]] GlBuffer allocate_buffer(std::size_t bytes);
// Does the same for a table. Throws GlError as make_table().
[[nodiscard]] GlTexture allocate_table(const GlTableFormat& format, std::size_t entries, const char* what);

class GradualBuffer {
 public:
  explicit GradualBuffer(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <typename T>
  explicit GradualBuffer(const std::vector<T>& values) : bytes_(std::as_bytes(std::span(values))) {}

  // Takes a buffer of allocate_buffer() for these bytes. Without it the first copy_some() allocates one.
  void use(GlBuffer allocated) { buffer_ = std::move(allocated); }
  // Copies one piece. Returns whether all are copied. Throws GlError.
  bool copy_some();
  [[nodiscard]] std::size_t bytes() const { return bytes_.size(); }
  [[nodiscard]] std::size_t copied_bytes() const { return copied_; }
  // Returns the buffer once all is copied.
  [[nodiscard]] GlBuffer take() { return std::move(buffer_); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t copied_ = 0;
  GlBuffer buffer_;
};

class GradualTable {
 public:
  // `what` names the table in errors; `entries` must outlive this object until take() or take_table().
  GradualTable(const GlTableFormat& format, const char* what, std::span<const std::byte> entries)
      : format_(format), what_(what), entries_(entries) {}
  template <typename T>
  GradualTable(const GlTableFormat& format, const char* what, const std::vector<T>& entries)
      : GradualTable(format, what, std::as_bytes(std::span(entries))) {}

  // Returns a call of allocate_table() for these entries, which any thread may make.
  [[nodiscard]] std::function<GlTexture()> allocation() const;
  // Takes the texture of allocation(). Without it the first copy_some() allocates one.
  void use(GlTexture allocated) { texture_ = std::move(allocated); }
  // Copies some rows. Returns whether all are copied. Throws GlError as make_table().
  bool copy_some();
  [[nodiscard]] std::uint64_t bytes() const { return table_bytes(format_, entry_count()); }
  [[nodiscard]] std::uint64_t copied_bytes() const { return row_ * kTableWidth * format_.entry_bytes; }
  // Return the table once all is copied. `entries`: the same, which the table keeps.
  [[nodiscard]] GlTexture take() { return std::move(texture_); }
  [[nodiscard]] GlTable take_table(std::vector<std::byte> entries) {
    return {format_, what_, std::move(texture_), std::move(entries)};
  }

 private:
  [[nodiscard]] std::size_t entry_count() const { return entries_.size() / format_.entry_bytes; }

  GlTableFormat format_;
  const char* what_;
  std::span<const std::byte> entries_;
  std::size_t row_ = 0;
  GlTexture texture_;
};

}  // namespace lumatlas
