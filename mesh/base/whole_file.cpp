// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/base/whole_file.h"

#include <fstream>
#include <system_error>

#include "mesh/base/errors.h"

namespace lumatlas {

std::string read_whole_file(const std::filesystem::path& path) {
  const auto fail = [&](const char* reason) { throw InputError(path.string() + ": " + reason); };
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) fail("no such file");
  if (!std::filesystem::is_regular_file(status)) fail("is not a file");
  std::ifstream file(path, std::ios::binary);
  if (!file) fail("cannot be opened; check that it may be read");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (!error && size == 0) fail("is empty");
  std::string bytes(error ? 0 : static_cast<std::size_t>(size), '\0');
  file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (error || !file) fail("cannot be read to its end");
  return bytes;
}

}  // namespace lumatlas
