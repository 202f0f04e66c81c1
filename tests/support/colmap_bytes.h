// SPDX-License-Identifier: GPL-3.0-or-later
// COLMAP's files, whole or damaged, built value by value.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

namespace lumatlas::test {

class Bytes {
 public:
  template <typename T>
  Bytes& add(T value) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    data_.append(raw.data(), raw.size());
    return *this;
  }
  Bytes& u32(std::uint32_t value) { return add(value); }
  Bytes& i32(std::int32_t value) { return add(value); }
  Bytes& u64(std::uint64_t value) { return add(value); }
  Bytes& f64(std::initializer_list<double> values) {
    for (const double value : values) add(value);
    return *this;
  }
  Bytes& text(std::string_view text) {
    data_.append(text);
    return *this;
  }

  // count, id, model, width, height, parameters
  Bytes& camera(std::uint32_t id, std::int32_t model, std::uint64_t width, std::uint64_t height,
                std::initializer_list<double> parameters) {
    return u32(id).i32(model).u64(width).u64(height).f64(parameters);
  }
  // `name` without its 0 byte; the points hold a pattern.
  Bytes& image(std::uint32_t id, std::array<double, 4> q, std::array<double, 3> t, std::uint32_t camera_id,
               std::string_view name, std::uint64_t points = 0) {
    u32(id).f64({q[0], q[1], q[2], q[3], t[0], t[1], t[2]}).u32(camera_id).text(name).text({"\0", 1}).u64(points);
    for (std::uint64_t i = 0; i < points; ++i) f64({1.0 * static_cast<double>(i), 2.5}).u64(~std::uint64_t{0});
    return *this;
  }

  Bytes cut(std::size_t size) const {
    Bytes shorter;
    shorter.data_ = data_.substr(0, size);
    return shorter;
  }
  [[nodiscard]] std::size_t size() const { return data_.size(); }
  [[nodiscard]] const std::string& string() const { return data_; }
  [[nodiscard]] std::span<const std::byte> span() const { return std::as_bytes(std::span(data_)); }

 private:
  std::string data_;
};

inline void write_file(const std::filesystem::path& path, std::string_view content) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
}

}  // namespace lumatlas::test
