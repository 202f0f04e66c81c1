// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/city/job_cost.h"

#include <sys/resource.h>
#include <unistd.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <system_error>

#include "mesh/base/errors.h"
#include "tools/base/output_folder.h"
#include "tools/base/strict_json.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

constexpr double kMicrosecond = 1e-6;

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + kMicrosecond * static_cast<double>(time.tv_usec);
}

// Returns the value of a line "NAME: VALUE" of /proc/self/io; 0 if there is none.
std::uint64_t bytes_by_calls(const std::string& name) {
  std::ifstream file("/proc/self/io");
  for (std::string word; file >> word;) {
    std::uint64_t bytes = 0;
    if (word == name + ":" && file >> bytes) return bytes;
  }
  return 0;
}

// Returns the time since this process began: the 22nd field of /proc/self/stat, in ticks since the system began.
double seconds_since_start() {
  std::ifstream stat("/proc/self/stat"), up("/proc/uptime");
  std::string line;
  double now = 0;
  if (!std::getline(stat, line) || !(up >> now)) return 0;
  std::istringstream fields(line.substr(line.rfind(')') + 1));  // the name before may have blanks
  std::string field;
  constexpr int kStart = 20;  // of those behind the name
  for (int i = 0; i < kStart; ++i) fields >> field;
  const double ticks = fields ? std::stod(field) : 0;
  return now - ticks / static_cast<double>(sysconf(_SC_CLK_TCK));
}

fs::path cost_file(const fs::path& plan, const std::string& name) {
  return plan / "costs" / (name + ".json");
}

}  // namespace

JobCost cost_of_this_process() {
  rusage usage{};
  JobCost cost;
  cost.wall_s = seconds_since_start();
  cost.read_bytes = bytes_by_calls("rchar");
  cost.written_bytes = bytes_by_calls("wchar");
  if (getrusage(RUSAGE_SELF, &usage) != 0) return cost;
  constexpr std::uint64_t kKibibyte = 1024;
  cost.processor_s = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  cost.peak_bytes = kKibibyte * static_cast<std::uint64_t>(usage.ru_maxrss);
  return cost;
}

void write_job_cost(const fs::path& plan, const std::string& name, const JobCost& cost) {
  const fs::path file = cost_file(plan, name);
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  if (error) throw InputError(file.parent_path().string() + ": cannot be made (" + error.message() + ")");
  write_json(file, {{"processor_s", cost.processor_s},
                    {"wall_s", cost.wall_s},
                    {"peak_bytes", cost.peak_bytes},
                    {"read_bytes", cost.read_bytes},
                    {"written_bytes", cost.written_bytes}});
}

std::optional<JobCost> read_job_cost(const fs::path& plan, const std::string& name) {
  const fs::path file = cost_file(plan, name);
  std::error_code ignored;
  if (!fs::exists(file, ignored)) return std::nullopt;
  const nlohmann::json document = read_json(file);
  const JsonPlace place(file.string(), "", document);
  place.expect_keys({"processor_s", "wall_s", "peak_bytes", "read_bytes", "written_bytes"}, {});
  const auto time = [&](const char* key) {
    const double value = place.at(key).number();
    if (value < 0) place.at(key).refuse("is below 0");
    return value;
  };
  constexpr std::size_t kMostBytes = std::size_t{1} << 53;  // exact in JSON
  const auto bytes = [&](const char* key) { return std::uint64_t{place.at(key).count(0, kMostBytes)}; };
  return JobCost{time("processor_s"), time("wall_s"), bytes("peak_bytes"), bytes("read_bytes"), bytes("written_bytes")};
}

}  // namespace lumatlas
