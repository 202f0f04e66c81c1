// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/gradual_copies.h"

#include <algorithm>

#include "blend/gl/egl_context.h"

namespace lumatlas {

namespace {

constexpr std::size_t kPieceBytes = 1 << 18;

}  // namespace

bool GradualBuffer::copy_some() {
  if (bytes_.empty()) {
    buffer_ = make_buffer(bytes_);
    return true;
  }
  if (buffer_.get() == 0) {
    GLuint name = 0;
    glGenBuffers(1, &name);
    buffer_ = GlBuffer(name);
    glBindBuffer(GL_COPY_WRITE_BUFFER, name);
    glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(bytes_.size()), nullptr, GL_STATIC_DRAW);
  } else {
    glBindBuffer(GL_COPY_WRITE_BUFFER, buffer_.get());
  }
  const std::size_t count = std::min(kPieceBytes, bytes_.size() - copied_);
  glBufferSubData(GL_COPY_WRITE_BUFFER, static_cast<GLintptr>(copied_), static_cast<GLsizeiptr>(count),
                  bytes_.data() + copied_);
  check_gl("storing a part of a buffer");
  copied_ += count;
  return copied_ == bytes_.size();
}

bool GradualTable::copy_some() {
  const std::size_t rows = table_rows(entries_.size() / format_.entry_bytes);
  if (texture_.get() == 0) texture_ = make_empty_table(format_, entries_.size() / format_.entry_bytes, what_);
  const std::size_t row_bytes = kTableWidth * format_.entry_bytes;
  const std::size_t count = std::min(std::max<std::size_t>(kPieceBytes / row_bytes, 1), rows - row_);
  copy_table_rows(texture_, format_, entries_, row_, count);
  row_ += count;
  return row_ == rows;
}

}  // namespace lumatlas
