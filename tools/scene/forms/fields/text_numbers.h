// SPDX-License-Identifier: GPL-3.0-or-later
// Texts of numbers between blanks and line ends, such as those of Bundler and VisualSFM, read without a copy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace lumatlas {

// Reads fields from the beginning of a text to its end. Allocates nothing that grows with the text. `what` names the
// value in sentences, such as "the focal length of camera 3".
class TextNumbers {
 public:
  // `text` and `path` must outlive this object.
  TextNumbers(std::string_view text, const std::filesystem::path& path) : rest_(text), path_(path) {}

  // The rest of the current line, or the next line that is not blank where nothing is left of it; without blanks
  // around it. Empty at the end of the text.
  [[nodiscard]] std::string_view line();

  // The next field, on this line or a later one. Empty at the end of the text.
  [[nodiscard]] std::string_view field();

  // The next field as a finite number. Throws InputError that names the line for any other field, and at the end of the
  // text.
  [[nodiscard]] double number(const std::string& what);

  // The next field as a number, NaN if it is none: some programs write "-1.#IND". Throws InputError only at the end of
  // the text.
  [[nodiscard]] double number_or_nan(const std::string& what);

  // The next field as a count of entries that take at least `least_bytes` bytes each in the rest of the text. Throws
  // InputError if they do not fit there.
  [[nodiscard]] std::uint64_t count(const std::string& what, std::uint64_t least_bytes);

  [[nodiscard]] bool at_end();  // nothing but blanks is left
  [[nodiscard]] char next();    // the first character of the next field, 0 at the end
  [[nodiscard]] std::size_t line_number() const { return number_; }  // the line that was read last

  // "PATH: line N: REASON", and the sentence for a text that ends too early.
  [[noreturn]] void refuse(const std::string& reason) const;
  [[noreturn]] void refuse_end(const std::string& what) const;

 private:
  void skip_blank_lines();

  std::string_view rest_;  // after line_
  std::string_view line_;
  std::size_t number_ = 0;  // the line's number, from 1
  const std::filesystem::path& path_;
};

}  // namespace lumatlas
