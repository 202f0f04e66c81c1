// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/readers/mesh_file.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <fstream>
#include <stdexcept>
#include <string>

#include "mesh/base/errors.h"
#include "mesh/base/file_ending.h"
#include "mesh/base/pending_file.h"
#include "mesh/base/text_fields.h"
#include "mesh/base/whole_file.h"
#include "mesh/readers/obj_reader.h"
#include "mesh/readers/ply_reader.h"
#include "mesh/readers/stl_reader.h"

namespace lumatlas {

namespace {

static_assert(std::endian::native == std::endian::little, "write_ply() copies numbers as they are in memory");

// Returns the header for a Mesh or a TriangleSoup, whose positions have the PLY type `number`.
template <typename Triangles>
std::string ply_header(const Triangles& mesh, const std::string& number) {
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.positions.size());
  for (const char* const axis : {" x", " y", " z"}) header += "\nproperty " + number + axis;
  header += '\n';
  if (!mesh.colors.empty()) header += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  header += "element face " + std::to_string(mesh.faces.size());
  return header + "\nproperty list uchar uint vertex_indices\nend_header\n";
}

void append_bytes(std::string& bytes, const void* data, std::size_t count) {
  bytes.append(static_cast<const char*>(data), count);
}

template <typename Triangles>
std::string ply_bytes(const Triangles& mesh, const std::string& number) {
  constexpr std::size_t kPositionBytes = sizeof(mesh.positions[0]), kColorBytes = 3, kFaceBytes = 13;
  std::string bytes = ply_header(mesh, number);
  bytes.reserve(bytes.size() + kPositionBytes * mesh.positions.size() + kColorBytes * mesh.colors.size() +
                kFaceBytes * mesh.faces.size());
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    append_bytes(bytes, &mesh.positions[i], kPositionBytes);
    if (!mesh.colors.empty()) append_bytes(bytes, &mesh.colors[i], kColorBytes);
  }
  for (const glm::uvec3& face : mesh.faces) {
    bytes.push_back(3);
    append_bytes(bytes, &face, sizeof face);
  }
  return bytes;
}

void check_soup(const TriangleSoup& soup) {
  if (!soup.colors.empty() && soup.colors.size() != soup.positions.size()) {
    throw std::invalid_argument("colors: " + std::to_string(soup.colors.size()) + ", must be none or one for each of " +
                                std::to_string(soup.positions.size()) + " positions");
  }
  (void)bounds(soup);
}

}  // namespace

TriangleSoup read_triangle_soup(const std::filesystem::path& path) {
  const std::string ending = lower_case_ending(path);
  if (ending == ".ply") return parse_ply(read_whole_file(path), path.string());
  if (ending == ".obj") return parse_obj(read_whole_file(path), path.string());
  if (ending == ".stl") return parse_stl(read_whole_file(path), path.string());
  throw InputError(path.string() + ": the ending " + in_quotes(ending) +
                   " is not .ply, .obj or .stl; convert the mesh to one of these");
}

void write_ply(const std::filesystem::path& path, const Mesh& mesh) {
  check(mesh);
  const std::string bytes = ply_bytes(mesh, "float");
  PendingFile file(path);
  std::ofstream stream(file.path(), std::ios::binary);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw InputError(path.string() + ": cannot be written; check the folder's permissions and free space");
  file.commit();
}

void write_ply(std::ostream& file, const TriangleSoup& soup) {
  check_soup(soup);
  const std::string bytes = ply_bytes(soup, "double");
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace lumatlas
