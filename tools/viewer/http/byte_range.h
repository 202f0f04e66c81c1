// SPDX-License-Identifier: GPL-3.0-or-later
// Reads which bytes of a file a Range header asks for (RFC 9110, section 14). No other code turns numbers of a request
// into an offset and a length: the result lies within the file, whatever the header says.
#pragma once

#include <cstdint>
#include <string_view>

namespace lumatlas {

struct ByteRange {
  enum class Answer {
    whole,          // all of the file, status 200: there is no range, or one that a server may ignore
    part,           // status 206
    unsatisfiable,  // no byte of the file, status 416
  };
  Answer answer = Answer::whole;
  std::uint64_t offset = 0, length = 0;  // offset + length is at most the file's size
};

// The bytes that `header`, the value of a Range header, asks for of a file of `size` bytes. A single range that holds a
// byte is cut off at the file's end. Several ranges in one header are answered with the whole file if one of them holds
// a byte, as a server may, and so is another unit than bytes. What is no list of ranges, as "bytes=9-8", is
// unsatisfiable.
[[nodiscard]] ByteRange byte_range(std::string_view header, std::uint64_t size);

}  // namespace lumatlas
