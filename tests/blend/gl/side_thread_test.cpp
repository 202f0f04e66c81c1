// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/side_thread.h"

#include <epoxy/gl.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "blend/gl/gradual_copies.h"
#include "tests/support/gl_test_context.h"
#include "tests/support/skip.h"

namespace lumatlas {
namespace {

bool context_of(SideThread& side) {
  std::optional<bool> known;
  while (!known) known = side.has_context();
  return *known;
}

// Says on which thread it was freed.
std::shared_ptr<const void> witness(std::atomic<std::thread::id>& freed_on) {
  return {new int(0), [&freed_on](const int* number) {
            freed_on = std::this_thread::get_id();
            delete number;
          }};
}

TEST_CASE("objects that were made aside are used in the context that draws") {
  const bool embedded = GENERATE(false, true);
  const std::optional<EglContext> context = context_or_skip({.debug = true, .embedded = embedded});
  if (!context) return;
  SideThread side;
  if (!context_of(side)) return skip("a driver without contexts that share objects");
  const std::thread::id here = std::this_thread::get_id();
  std::atomic<std::thread::id> made_on;
  GlBuffer buffer = side.make([&] {
                          made_on = std::this_thread::get_id();
                          return allocate_buffer(64);
                        })
                        .get();
  CHECK(made_on != here);
  GlTexture table = side.make([] { return allocate_table(kNumbers, 1, "numbers"); }).get();
  const std::vector<std::uint32_t> values{1, 2, 3};
  copy_table_rows(table, kNumbers, std::as_bytes(std::span(values)), 0, 1);
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer.get());
  glBufferSubData(GL_COPY_WRITE_BUFFER, 0, 12, values.data());
  CHECK_NOTHROW(check_gl("using them"));
  const auto* const read =
      static_cast<const std::uint32_t*>(glMapBufferRange(GL_COPY_WRITE_BUFFER, 0, 12, GL_MAP_READ_BIT));
  REQUIRE(read != nullptr);
  CHECK(std::vector<std::uint32_t>(read, read + 3) == values);
  glUnmapBuffer(GL_COPY_WRITE_BUFFER);
  const GLuint name = table.get();
  CHECK(glIsTexture(name) == GL_TRUE);
  auto texture = std::make_shared<GlTexture>(std::move(table));
  side.free_objects(std::move(texture));
  (void)side.make([] { return 0; }).get();  // all that was asked for before is done
  CHECK(glIsTexture(name) == GL_FALSE);
}

TEST_CASE("what fails aside is told to the one who asked, and the thread goes on") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  SideThread side;
  if (!context_of(side)) return skip("a driver without contexts that share objects");
  auto fails = side.make([]() -> int { throw GlError("no memory for it"); });
  auto works = side.make([] { return 5; });
  CHECK_THROWS_AS(fails.get(), GlError);
  CHECK(works.get() == 5);
  const auto most = static_cast<std::size_t>(gl_limit(GL_MAX_TEXTURE_SIZE));
  auto too_large = side.make([&] { return allocate_table(kNumbers, (most + 1) * kTableWidth, "numbers"); });
  CHECK_THROWS_AS(too_large.get(), GlError);
}

TEST_CASE("memory is freed on the other thread, with a context or without, and before the object's end at the latest") {
  const std::optional<EglContext> context = context_or_skip();
  const bool with_context = GENERATE(true, false);
  if (with_context && !context) return;
  std::atomic<std::thread::id> freed_on;
  {
    SideThread side;
    if (with_context) (void)context_of(side);
    side.free_later(witness(freed_on));
  }
  CHECK(freed_on.load() != std::thread::id());
  CHECK(freed_on.load() != std::this_thread::get_id());
}

TEST_CASE("without a current context of EGL there is none aside, and objects are freed at once") {
  SideThread side;
  CHECK(side.has_context() == std::optional(false));
  CHECK(side.has_context() == std::optional(false));  // asked again
  std::atomic<std::thread::id> freed_on;
  side.free_objects(witness(freed_on));
  CHECK(freed_on.load() == std::this_thread::get_id());
}

TEST_CASE("results that are not waited for are freed, and the end waits for what is asked for") {
  const std::optional<EglContext> context = context_or_skip();
  if (!context) return;
  std::atomic<int> made = 0;
  std::atomic<std::thread::id> freed_on;
  GLuint name = 0;
  {
    SideThread side;
    if (!context_of(side)) return skip("a driver without contexts that share objects");
    for (int i = 0; i < 20; ++i) {
      (void)side.make([&] {
        ++made;
        return allocate_table(kNumbers, 100, "numbers");
      });
    }
    (void)side.make([&] {
      GlTexture texture = allocate_table(kNumbers, 100, "numbers");
      name = texture.get();
      return texture;
    });
    side.free_later(witness(freed_on));
  }
  CHECK(made == 20);
  CHECK(freed_on.load() != std::thread::id());
  CHECK(glIsTexture(name) == GL_FALSE);
}

}  // namespace
}  // namespace lumatlas
