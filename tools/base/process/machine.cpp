// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/base/process/machine.h"

#include <sys/utsname.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string_view>
#include <thread>
#include <vector>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

// Returns the text after `key` and a colon in a file of such lines; empty if there is none.
std::string value_in(const char* path, std::string_view key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with(key)) continue;
    const std::size_t colon = line.find(':');
    const std::size_t start = line.find_first_not_of(" \t", colon == std::string::npos ? colon : colon + 1);
    return start == std::string::npos ? "" : line.substr(start);
  }
  return "";
}

std::string memory() {
  const std::string kilobytes = value_in("/proc/meminfo", "MemTotal");
  if (kilobytes.empty()) return "";
  char text[32];
  std::snprintf(text, sizeof(text), ", %.1f GiB", std::strtod(kilobytes.c_str(), nullptr) / (1 << 20));
  return text;
}

// FNV-1a, 64 bits.
std::string hash_of_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw InputError(path.string() + ": cannot be read");
  std::uint64_t hash = 0xcbf29ce484222325;
  std::vector<char> bytes(1 << 16);
  while (file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())), file.gcount() > 0) {
    for (std::streamsize i = 0; i < file.gcount(); ++i) {
      hash = (hash ^ static_cast<unsigned char>(bytes[static_cast<std::size_t>(i)])) * 0x100000001b3;
    }
  }
  char text[17];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace

std::string machine_description() {
  std::string processor = value_in("/proc/cpuinfo", "model name");
  utsname system{};
  const bool known = uname(&system) == 0;
  if (processor.empty()) processor = known ? system.machine : "unknown processor";
  const unsigned cores = std::thread::hardware_concurrency();
  return processor + ", " + std::to_string(cores) + (cores == 1 ? " core" : " cores") + memory() +
         (known ? std::string(", ") + system.sysname + " " + system.release : "");
}

std::uint64_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t all = 0, resident = 0;
  file >> all >> resident;
  return file ? resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) : 0;
}

std::filesystem::path program_file() {
  std::error_code error;
  std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) throw InputError("/proc/self/exe: cannot be read, the program does not find itself: " + error.message());
  return path;
}

std::string program_identity(const std::string& version, const std::string& commit,
                             const std::filesystem::path& program) {
  const bool is_clean = !commit.empty() && !commit.ends_with("-dirty");
  const std::string name = version + " commit " + (commit.empty() ? "unknown" : commit);
  return is_clean ? name : name + " (program " + hash_of_file(program) + ")";
}

}  // namespace lumatlas
