// SPDX-License-Identifier: GPL-3.0-or-later
#include "atlas/images/pixel_memory.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <numeric>
#include <optional>
#include <thread>
#include <vector>

#include "atlas/images/pixel_buffer.h"
#include "atlas/images/pixel_list.h"
#include "atlas/images/stored_photograph.h"
#include "mesh/base/errors.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tests/support/temporary_folder.h"

namespace lumatlas {
namespace {

constexpr std::size_t kBuffer = kLeastBoundBytes;  // bytes of a buffer of these tests, which all count

std::vector<std::uint32_t> numbers(std::uint32_t first) {
  std::vector<std::uint32_t> values(kBuffer / sizeof(std::uint32_t));
  std::iota(values.begin(), values.end(), first);
  return values;
}

std::size_t entries_of(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator()));
}

TEST_CASE("buffers are in memory up to the bound, and in scratch files beyond it") {
  const TemporaryFolder folder;
  const PixelMemory before = pixel_memory();
  const PixelMemoryBound bound(before.in_memory + 2 * kBuffer, folder.path());
  std::vector<PixelBuffer<std::uint32_t>> buffers;
  for (std::uint32_t i = 0; i < 5; ++i) {
    buffers.emplace_back(numbers(i));
    CHECK(pixel_memory().in_memory <= before.in_memory + 2 * kBuffer);
  }
  CHECK(pixel_memory().in_memory == before.in_memory + 2 * kBuffer);
  CHECK(pixel_memory().in_files == before.in_files + 3 * kBuffer);
  for (std::uint32_t i = 0; i < 5; ++i) {
    CHECK(buffers[i].in_memory() == (i < 2));
    CHECK(buffers[i].bytes() == (i < 2 ? kBuffer : 0));
    CHECK(std::ranges::equal(buffers[i], numbers(i)));
  }
  CHECK(entries_of(folder.path()) == 0);  // the files have no names
  buffers.erase(buffers.begin());
  buffers.emplace_back(numbers(9));
  CHECK(buffers.back().in_memory());  // in the place of the one that is gone
  buffers.clear();
  CHECK(pixel_memory().in_memory == before.in_memory);
  CHECK(pixel_memory().in_files == before.in_files);
}

TEST_CASE("copies of buffers keep the bound, and their values may be changed apart") {
  const TemporaryFolder folder;
  const PixelMemory before = pixel_memory();
  const PixelMemoryBound bound(before.in_memory + kBuffer, folder.path());
  const PixelBuffer<std::uint32_t> in_memory(numbers(1)), in_file(numbers(2));
  PixelBuffer<std::uint32_t> of_memory = in_memory, of_file = in_file;
  CHECK_FALSE(of_memory.in_memory());
  CHECK_FALSE(of_file.in_memory());
  CHECK(of_file.data() == in_file.data());  // one file for both
  of_file.values()[7] = 0;
  of_memory.values().push_back(5);
  CHECK(in_file[7] == 9);
  CHECK(of_file[7] == 0);
  CHECK(in_memory.size() + 1 == of_memory.size());
  of_memory = in_file;
  CHECK(std::ranges::equal(of_memory, numbers(2)));
}

TEST_CASE("a small buffer is always in memory") {
  const TemporaryFolder folder;
  const PixelMemoryBound bound(0, folder.path());
  CHECK(PixelBuffer(std::vector<std::uint8_t>(kLeastBoundBytes - 1)).in_memory());
  CHECK_FALSE(PixelBuffer(std::vector<std::uint8_t>(kLeastBoundBytes)).in_memory());
  CHECK(PixelBuffer(std::vector<std::uint8_t>()).empty());
}

TEST_CASE("the newest bound counts, and none when all are gone") {
  const TemporaryFolder folder;
  std::optional<PixelMemoryBound> outer, inner;
  outer.emplace(std::numeric_limits<std::uint64_t>::max(), folder.path());
  inner.emplace(0, folder.path());
  CHECK_FALSE(PixelBuffer(numbers(0)).in_memory());
  outer.reset();
  CHECK_FALSE(PixelBuffer(numbers(0)).in_memory());
  const PixelBuffer<std::uint32_t> outlives(numbers(3));
  inner.reset();
  CHECK(PixelBuffer(numbers(0)).in_memory());
  CHECK(std::ranges::equal(outlives, numbers(3)));
}

TEST_CASE("the bound holds while many threads make buffers") {
  const TemporaryFolder folder;
  const std::uint64_t most = pixel_memory().in_memory + 4 * kBuffer;
  const PixelMemoryBound bound(most, folder.path());
  std::vector<std::thread> threads;
  std::vector<int> wrong(8, 0);
  for (std::uint32_t thread = 0; thread < wrong.size(); ++thread) {
    threads.emplace_back([&, thread] {
      for (std::uint32_t i = 0; i < 20; ++i) {
        const PixelBuffer<std::uint32_t> one(numbers(i)), other = one;
        wrong[thread] += pixel_memory().in_memory > most ? 1 : 0;
        wrong[thread] += std::ranges::equal(one, other) && other[1] == i + 1 ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == std::vector<int>(8, 0));
}

TEST_CASE("photographs and lists of pixels read the same from a scratch file as from memory") {
  const TemporaryFolder folder;
  Photograph given = position_photograph(400, 300);
  given.valid.assign(400 * 300, 255);
  given.valid[4321] = 0;
  const StoredPhotograph in_memory{Photograph(given)};
  const PixelMemoryBound bound(0, folder.path());
  const StoredPhotograph in_file{Photograph(given)};
  CHECK(in_file.bytes() == 0);
  CHECK(in_file == in_memory);
  CHECK(in_file.color(4321) == in_memory.color(4321));
  CHECK_FALSE(in_file.is_inside_lens(4321));
  CHECK(in_file.whole().rgb == given.rgb);
  CHECK(in_file.valid() == given.valid);
  CHECK(std::ranges::equal(in_file.span().rgb, given.rgb));
  PixelList<float> depths(std::vector<float>(400 * 300, 2.5f));
  CHECK(depths.bytes() == 0);
  CHECK(depths[77] == 2.5f);
  depths.values()[77] = 1;
  CHECK(depths[77] == 1);
}

TEST_CASE("lists of parts are within the bound once they are settled") {
  const TemporaryFolder folder;
  const PixelMemory before = pixel_memory();
  const PixelMemoryBound bound(before.in_memory, folder.path());
  constexpr std::uint32_t kSide = 512;
  const PixelRect part{64, 64, 256, 256};
  PixelList<std::uint32_t> parts(kSide, kSide, 7);
  const std::size_t tables = parts.bytes();
  std::vector<std::uint32_t> values(part.pixels());
  std::iota(values.begin(), values.end(), 100);
  parts.set_part(part, values);
  CHECK(pixel_memory().in_files == before.in_files);
  parts.settle();
  CHECK(pixel_memory().in_files == before.in_files + sizeof(std::uint32_t) * part.pixels());
  CHECK(parts.bytes() < tables + sizeof(std::uint32_t) * part.pixels() / 16);
  CHECK(parts[0] == 7);
  CHECK(parts[std::size_t{65} * kSide + 66] == 100 + 256 + 2);
  std::size_t there = 0;
  parts.for_each([&](std::size_t pixel, std::uint32_t value) {
    const std::size_t x = pixel % kSide - 64, y = pixel / kSide - 64;
    if (value != 100 + 256 * y + x) FAIL_CHECK("pixel " << pixel);
    ++there;
  });
  CHECK(there == part.pixels());
}

TEST_CASE("a folder that takes no scratch file is named") {
  const TemporaryFolder folder;
  CHECK_THROWS_WITH(PixelMemoryBound(0, folder.path() / "none"),
                    Catch::Contains("none: is no folder") && Catch::Contains("TMPDIR"));
  const std::filesystem::path gone = folder.path() / "gone";
  std::filesystem::create_directory(gone);
  const std::uint64_t files_before = pixel_memory().in_files;
  const PixelMemoryBound bound(0, gone);
  std::filesystem::remove(gone);
  CHECK_THROWS_AS(PixelBuffer(numbers(0)), InputError);
  CHECK(pixel_memory().in_files == files_before);
}

TEST_CASE("the usual memory is a share of what the system has") {
  CHECK(usual_pixel_memory() >= std::uint64_t{256} << 20);
}

}  // namespace
}  // namespace lumatlas
