// SPDX-License-Identifier: GPL-3.0-or-later
// Internal to atlas/: the fields of JSON objects, and files that lie beside the JSON, with every check that a hostile
// file needs. Every refusal is an InputError of one line that names the JSON's file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "atlas/model/gltf/tiny_gltf.h"

namespace lumatlas {

// An image, not decoded: a file, or bytes of a buffer.
struct GltfImage {
  std::filesystem::path file;            // in a buffer: what stands for it in sentences
  std::span<const unsigned char> bytes;  // empty: in `file`
};

class FieldReader {
 public:
  using Object = tinygltf::Value;

  explicit FieldReader(std::filesystem::path path) : path_(std::move(path)) {}

  [[noreturn]] void refuse(const std::string& why) const;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

  // Fields of an object; `where` names it in refusals.
  [[nodiscard]] const Object& field(const Object& object, const std::string& where, const char* name) const;
  [[nodiscard]] double number(const Object& object, const std::string& where, const char* name, double least,
                              double most) const;
  [[nodiscard]] std::uint32_t whole_number(const Object& object, const std::string& where, const char* name,
                                           std::uint32_t least, std::uint32_t most) const;
  [[nodiscard]] std::vector<double> numbers(const Object& object, const std::string& where, const char* name,
                                            std::size_t count) const;  // all finite
  [[nodiscard]] std::vector<double> numbers(const Object& object, const std::string& where, const char* name,
                                            std::size_t count, double least, double most) const;
  [[nodiscard]] std::string text(const Object& object, const std::string& where, const char* name) const;  // one line
  [[nodiscard]] int accessor(const Object& object, const std::string& where, const char* name) const;

  // Returns the file that a URI names, which lies in the folder of the JSON, not even behind a symbolic link elsewhere.
  // `where` names what the URI is of.
  [[nodiscard]] std::filesystem::path file_beside(const std::string& uri, const std::string& where) const;

 private:
  void require_within(double x, const std::string& what, double least, double most) const;

  std::filesystem::path path_;
};

// The value as the reader of fields has it.
[[nodiscard]] tinygltf::Value value_of(const nlohmann::json& json);

// A path relative to a model's folder that leads nowhere else.
[[nodiscard]] bool stays_in_folder(const std::filesystem::path& relative);
// Returns whether a file's path leads out of the model's folder once symbolic links are followed.
[[nodiscard]] bool leads_out_of(const std::filesystem::path& folder, const std::filesystem::path& file);
[[nodiscard]] bool has_control_character(const std::string& text);

inline constexpr std::uint32_t kMostIndex = 1'000'000'000;  // of an object in a list

}  // namespace lumatlas
