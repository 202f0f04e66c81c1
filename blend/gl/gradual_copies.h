// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to blend/: buffers and tables that are copied to the GPU piece by piece, so that a frame waits for none of
// them. The bytes must stay until all are copied.
#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "blend/gl/gl_objects.h"

namespace lumatlas {

class GradualBuffer {
 public:
  explicit GradualBuffer(std::span<const std::byte> bytes) : bytes_(bytes) {}
  template <typename T>
  explicit GradualBuffer(const std::vector<T>& values) : bytes_(std::as_bytes(std::span(values))) {}

  // Copies one piece; the first call makes the buffer. Returns whether all are copied. Throws GlError.
  bool copy_some();
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

  // Copies some rows; the first call makes the texture. Returns whether all are copied. Throws GlError as make_table().
  bool copy_some();
  // Return the table once all is copied.
  [[nodiscard]] GlTexture take() { return std::move(texture_); }
  [[nodiscard]] GlTable take_table() { return {format_, what_, std::move(texture_), entries_}; }

 private:
  GlTableFormat format_;
  const char* what_;
  std::span<const std::byte> entries_;
  std::size_t row_ = 0;
  GlTexture texture_;
};

}  // namespace lumatlas
