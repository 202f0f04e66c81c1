// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/gradual_copies.h"

#include <algorithm>

#include "blend/gl/egl_context.h"

namespace lumatlas {

GlBuffer allocate_buffer(std::size_t bytes) {
  GLuint name = 0;
  glGenBuffers(1, &name);
  GlBuffer buffer(name);
  glBindBuffer(GL_COPY_WRITE_BUFFER, name);
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes), nullptr, GL_STATIC_DRAW);
  glBindBuffer(GL_COPY_WRITE_BUFFER, 0);
  check_gl("allocating a buffer");
  return buffer;
}

GlTexture allocate_table(const GlTableFormat& format, std::size_t entries, const char* what) {
  GlTexture table = make_empty_table(format, entries, what);
  glBindTexture(GL_TEXTURE_2D, 0);
  return table;
}

bool GradualBuffer::copy_some() {
  if (bytes_.empty()) {
    buffer_ = make_buffer(bytes_);
    return true;
  }
  if (buffer_.get() == 0) buffer_ = allocate_buffer(bytes_.size());
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer_.get());
  const std::size_t count = std::min(kPieceBytes, bytes_.size() - copied_);
  glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(copied_), static_cast<GLsizeiptr>(count),
                  bytes_.data() + copied_);
  check_gl("storing a part of a buffer");
  copied_ += count;
  return copied_ == bytes_.size();
}

std::function<GlTexture()> GradualTable::allocation() const {
  return [format = format_, entries = entry_count(), what = what_] { return allocate_table(format, entries, what); };
}

bool GradualTable::copy_some() {
  const std::size_t rows = table_rows(entry_count());
  if (texture_.get() == 0) texture_ = allocation()();
  const std::size_t row_bytes = kTableWidth * format_.entry_bytes;
  const std::size_t count = std::min(std::max<std::size_t>(kPieceBytes / row_bytes, 1), rows - row_);
  copy_table_rows(texture_, format_, entries_, row_, count);
  row_ += count;
  return row_ == rows;
}

}  // namespace lumatlas
