// SPDX-License-Identifier: GPL-3.0-or-later
// Values of pixels that are kept for long: in memory, or in a scratch file where memory is short.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "atlas/images/pixel_memory.h"

namespace lumatlas {

// Takes the values of a vector, in memory as long as that is within the bound of PixelMemoryBound. Reads like a vector.
template <typename T>
class PixelBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  PixelBuffer() = default;
  // Throws InputError if the values must go to a scratch file that cannot be written.
  explicit PixelBuffer(std::vector<T> values) : memory_(std::move(values)) {
    const std::size_t bytes = sizeof(T) * memory_.size();
    if (bytes < kLeastBoundBytes) return;
    if (PixelMemoryShare::take(bytes)) {
      share_ = PixelMemoryShare(bytes);
      return;
    }
    file_ = std::make_shared<const ScratchFile>(std::as_bytes(std::span(memory_)));
    std::vector<T>().swap(memory_);
  }
  // A copy shares the scratch file; a copy of values in memory is within the bound again.
  PixelBuffer(const PixelBuffer& other) : PixelBuffer(std::vector<T>(other.memory_)) {
    if (other.file_) file_ = other.file_;
  }
  PixelBuffer(PixelBuffer&& other) noexcept = default;
  PixelBuffer& operator=(const PixelBuffer& other) {
    if (this != &other) *this = PixelBuffer(other);
    return *this;
  }
  PixelBuffer& operator=(PixelBuffer&& other) noexcept = default;
  ~PixelBuffer() = default;

  [[nodiscard]] std::size_t size() const { return file_ ? file_->size() / sizeof(T) : memory_.size(); }
  [[nodiscard]] bool empty() const { return size() == 0; }
  [[nodiscard]] const T* data() const {
    return file_ ? reinterpret_cast<const T*>(file_->data()) : memory_.data();  // a file is mapped at a page's start
  }
  [[nodiscard]] const T& operator[](std::size_t index) const { return data()[index]; }
  [[nodiscard]] const T* begin() const { return data(); }
  [[nodiscard]] const T* end() const { return data() + size(); }

  [[nodiscard]] bool in_memory() const { return !file_; }
  // Returns the bytes of memory that the values take.
  [[nodiscard]] std::size_t bytes() const { return sizeof(T) * memory_.size(); }

  // Returns the values, in memory, where they may be changed. They still count as before.
  [[nodiscard]] std::vector<T>& values() {
    if (file_) {
      memory_.assign(begin(), end());
      file_.reset();
    }
    return memory_;
  }

 private:
  std::vector<T> memory_;
  std::shared_ptr<const ScratchFile> file_;  // null: in memory
  PixelMemoryShare share_;
};

}  // namespace lumatlas
