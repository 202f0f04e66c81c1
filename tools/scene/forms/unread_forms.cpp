// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/unread_forms.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string_view>
#include <system_error>

#include "tools/base/process/child_process.h"
#include "tools/scene/forms/capture.h"
#include "tools/scene/forms/photographs/photograph_names.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

struct UnreadFile {
  const char* path;  // relative to the folder; with a '*', any file in the folder with this ending
  const char* program;
};

// Files of programs that find out poses, or keep captures, in ways that this program does not read.
constexpr std::array kUnreadFiles{
    UnreadFile{"sfm_data.bin", "OpenMVG, of which sfm_data.json is read"},
    UnreadFile{"*.nvm", "VisualSFM, of which version 3 is read"},
    UnreadFile{"*.sfm", "Meshroom, without poses that are read"},
    UnreadFile{"*.abc", "Meshroom, of which cameras.sfm is read"},
    UnreadFile{"*.psx", "Metashape, of which the XML of its cameras is read"},
    UnreadFile{"*.psz", "Metashape, of which the XML of its cameras is read"},
    UnreadFile{"*.rcproj", "RealityCapture, of which the CSV of its cameras is read"},
    UnreadFile{"*.rspj", "RealityScan, of which the CSV of its cameras is read"},
    UnreadFile{"*.mvs", "OpenMVS, as an archive of its own, of which the exchange file is read"},
    UnreadFile{"*.sens", "ScanNet, of which the exported folders are read"},
    UnreadFile{"*.r3d", "Record3D"},
    UnreadFile{"*.p4d", "Pix4D"},
};

std::optional<fs::path> file_like(const fs::path& scene, std::string_view pattern) {
  if (pattern.starts_with('*')) {
    const std::vector<fs::path> files = files_ending_in(scene, pattern.substr(1));
    return files.empty() ? std::nullopt : std::optional(files.front().filename());
  }
  std::error_code ignored;
  return fs::is_regular_file(scene / pattern, ignored) ? std::optional<fs::path>(pattern) : std::nullopt;
}

// A .csv that names heights and angles of cameras, but not as the reader expects it.
std::optional<fs::path> other_columns(const fs::path& scene) {
  for (const fs::path& file : files_ending_in(scene, ".csv")) {
    std::string head = first_bytes(file);
    std::transform(head.begin(), head.end(), head.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto has = [&](const char* word) { return head.find(word) != std::string::npos; };
    if (has("name,") && has(",alt") && has(",pitch") && has(",roll")) return file.filename();
  }
  return std::nullopt;
}

constexpr const char* kReadForms =
    "COLMAP, transforms.json, Polycam, Metashape, RealityCapture, OpenMVS, OpenSfM, OpenMVG, Meshroom, VisualSFM, "
    "Bundler, ScanNet and TUM RGB-D are read";

}  // namespace

std::string unread_form_hint(const fs::path& scene) {
  if (const std::optional<fs::path> csv = other_columns(scene)) {
    return "; " + csv->string() +
           " looks like cameras of RealityCapture, whose columns must be name, x, y, alt, heading, pitch, roll and f: "
           "export it again as \"Internal/External camera parameters\"";
  }
  for (const UnreadFile& file : kUnreadFiles) {
    const std::optional<fs::path> path = file_like(scene, file.path);
    if (!path) continue;
    return "; it holds " + path->string() + " of " + file.program + ", which is not read: export COLMAP's form (" +
           kReadForms + ")";
  }
  std::error_code ignored;
  const fs::path images = scene / "images";
  const std::size_t photographs = pictures_in(fs::is_directory(images, ignored) ? images : scene).size();
  if (photographs == 0) return {};
  return "; it holds " + std::to_string(photographs) + " photographs: `" +
         shell_line("lumatlas", {"capture", (fs::is_directory(images, ignored) ? images : scene).string()}) +
         "` finds out where they were taken";
}

std::string no_poses(const fs::path& scene) {
  return scene.string() +
         ": holds no COLMAP model (cameras.bin and images.bin, or cameras.txt and images.txt, in sparse/, sparse/0/ or "
         "itself) and no transforms.json or other form of capture" +
         unread_form_hint(scene);
}

}  // namespace lumatlas
