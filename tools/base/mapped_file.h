// SPDX-License-Identifier: GPL-3.0-or-later
// A file's bytes without reading those that nobody looks at.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string_view>

namespace lumatlas {

class MappedFile {
 public:
  // Throws InputError if the path is no regular file or cannot be opened.
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::span<const std::byte> bytes() const { return {data_, size_}; }
  [[nodiscard]] std::string_view text() const { return {reinterpret_cast<const char*>(data_), size_}; }

 private:
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace lumatlas
