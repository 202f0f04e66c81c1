// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <fstream>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "mesh/base/pending_file.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "mesh/obj_reader.h"
#include "mesh/ply_reader.h"

namespace lumatlas {

namespace {

static_assert(std::endian::native == std::endian::little, "write_ply() copies numbers as they are in memory");

std::string lower_case_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

std::string ply_header(const Mesh& mesh) {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.positions.size());
  header += "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!mesh.colors.empty()) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  header += "element face " + std::to_string(mesh.faces.size());
  return header + "\nproperty list uchar uint vertex_indices\nend_header\n";
}

void append_bytes(std::string& bytes, const void* data, std::size_t count) {
  bytes.append(static_cast<const char*>(data), count);
}

std::string ply_bytes(const Mesh& mesh) {
  constexpr std::size_t kVertexBytes = 12, kColorBytes = 3, kFaceBytes = 13;
  std::string bytes = ply_header(mesh);
  bytes.reserve(bytes.size() + kVertexBytes * mesh.positions.size() + kColorBytes * mesh.colors.size() +
                kFaceBytes * mesh.faces.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    append_bytes(bytes, &mesh.positions[i], kVertexBytes);
    if (!mesh.colors.empty()) append_bytes(bytes, &mesh.colors[i], kColorBytes);
  }
  for (const glm::uvec3& face : mesh.faces) {
    bytes.push_back(3);
    append_bytes(bytes, &face, sizeof face);
  }
  return bytes;
}

}  // namespace

TriangleSoup read_triangle_soup(const std::filesystem::path& path) {
  const std::string ending = lower_case_ending(path);
  if (ending == ".ply") return parse_ply(read_whole_file(path), path.string());
  if (ending == ".obj") return parse_obj(read_whole_file(path), path.string());
  throw InputError(path.string() + ": the ending " + in_quotes(ending) +
                   " is not .ply or .obj; convert the mesh to one of these");
}

void write_ply(const std::filesystem::path& path, const Mesh& mesh) {
  check(mesh);
  const std::string bytes = ply_bytes(mesh);
  PendingFile file(path);
  std::ofstream stream(file.path(), std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw InputError(path.string() + ": cannot be written; check the folder's permissions and free space");
  file.commit();
}

}  // namespace lumatlas
