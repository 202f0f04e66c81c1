// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/gradual_copies.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "tests/support/gl_test_context.h"

namespace lumatlas {
namespace {

std::vector<std::uint32_t> numbers(std::size_t count) {
  std::vector<std::uint32_t> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<std::uint32_t>(2654435761u * i);
  return values;
}

std::vector<std::uint32_t> read_buffer(const GlBuffer& buffer, std::size_t count) {
  std::vector<std::uint32_t> values(count);
  glBindBuffer(GL_COPY_READ_BUFFER, buffer.get());
  const void* const bytes =
      glMapBufferRange(GL_COPY_READ_BUFFER, 0, static_cast<GLsizeiptr>(4 * count), GL_MAP_READ_BIT);
  REQUIRE(bytes != nullptr);
  std::memcpy(values.data(), bytes, 4 * count);
  glUnmapBuffer(GL_COPY_READ_BUFFER);
  return values;
}

std::vector<std::uint32_t> read_table(const GlTexture& table, std::size_t rows) {
  std::vector<std::uint32_t> values(rows * kTableWidth);
  glBindTexture(GL_TEXTURE_2D, table.get());
  glGetTexImage(GL_TEXTURE_2D, 0, GL_RED_INTEGER, GL_UNSIGNED_INT, values.data());
  return values;
}

TEST_CASE("a buffer, allocated before or not, is copied in pieces of a bounded size, and holds all bytes then") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const std::size_t count = GENERATE(1, 1000, kPieceBytes / 4, kPieceBytes / 4 + 1, 500'000);
  const bool given = GENERATE(false, true);
  const std::vector<std::uint32_t> values = numbers(count);
  GradualBuffer gradual(values);
  CHECK(gradual.bytes() == 4 * count);
  if (given) gradual.use(allocate_buffer(4 * count));
  std::size_t calls = 0;
  bool is_whole = false;
  while (!is_whole) {
    const std::size_t before = gradual.copied_bytes();
    is_whole = gradual.copy_some();
    CHECK(gradual.copied_bytes() > before);
    CHECK(gradual.copied_bytes() - before <= kPieceBytes);
    ++calls;
  }
  CHECK(calls == (4 * count + kPieceBytes - 1) / kPieceBytes);
  CHECK(gradual.copied_bytes() == 4 * count);
  CHECK(read_buffer(gradual.take(), count) == values);
}

TEST_CASE("an empty buffer takes one call") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  GradualBuffer gradual(std::vector<std::uint32_t>{});
  CHECK(gradual.copy_some());
  CHECK(gradual.take().get() != 0);
}

TEST_CASE("a table, allocated before or not, is copied in rows of a bounded size, with zeros after its last entry") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const std::size_t count = GENERATE(0, 1, kTableWidth, kTableWidth + 1, 300'000);
  const bool given = GENERATE(false, true);
  const std::vector<std::uint32_t> values = numbers(count);
  GradualTable gradual(kNumbers, "numbers", values);
  if (given) gradual.use(gradual.allocation()());
  bool is_whole = false;
  while (!is_whole) {
    const std::uint64_t before = gradual.copied_bytes();
    is_whole = gradual.copy_some();
    CHECK(gradual.copied_bytes() > before);
    CHECK(gradual.copied_bytes() - before <= kPieceBytes);
  }
  CHECK(gradual.copied_bytes() == gradual.bytes());
  std::vector<std::uint32_t> expected = values;
  expected.resize(table_rows(count) * kTableWidth);
  CHECK(read_table(gradual.take(), table_rows(count)) == expected);
}

TEST_CASE("a table that was copied in rows copies only what has changed from then on") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  std::vector<std::uint32_t> values = numbers(5000);
  GradualTable gradual(kNumbers, "numbers", values);
  while (!gradual.copy_some()) {
  }
  const auto bytes = std::as_bytes(std::span<const std::uint32_t>(values));
  GlTable table = gradual.take_table({bytes.begin(), bytes.end()});
  const GLuint name = table.texture().get();
  values[2500] = 7;
  table.store(std::as_bytes(std::span<const std::uint32_t>(values)));
  CHECK(table.texture().get() == name);
  std::vector<std::uint32_t> expected = values;
  expected.resize(table_rows(5000) * kTableWidth);
  CHECK(read_table(table.texture(), table_rows(5000)) == expected);
}

TEST_CASE("what is allocated is left unbound, so that its memory is freed with it") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  const GlBuffer buffer = allocate_buffer(100);
  const GlTexture table = allocate_table(kNumbers, 100, "numbers");
  GLint bound = -1;
  glGetIntegerv(GL_COPY_WRITE_BUFFER_BINDING, &bound);
  CHECK(bound == 0);
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &bound);
  CHECK(bound == 0);
}

}  // namespace
}  // namespace lumatlas
