// SPDX-License-Identifier: GPL-3.0-or-later
// glTF 2.0, sections 3.5 (nodes) and 3.7 (meshes).
#include "atlas/model/gltf/gltf_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "atlas/images/srgb.h"
#include "atlas/model/gltf/gltf_file.h"
#include "atlas/model/model_extension.h"
#include "mesh/readers/polygons.h"

namespace lumatlas {

namespace {

// Nodes may show one mesh again and again, so a small file could fill any memory.
constexpr std::uint64_t kMostGrowth = 64;           // times the bytes of its buffers
constexpr std::uint64_t kMostDecodedGrowth = 8;     // times the bytes of its compressed views, once decoded
constexpr std::uint64_t kAlwaysAllowed = 16 << 20;  // bytes

template <typename T>
double loaded(const unsigned char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

// Section 3.11 of the specification says how integers stand for fractions.
template <typename T>
double integer_at(const unsigned char* first, int component, bool normalized) {
  const double value = loaded<T>(first + static_cast<std::size_t>(component) * sizeof(T));
  return normalized ? std::max(value / std::numeric_limits<T>::max(), -1.0) : value;
}

double component_at(const GltfElements& elements, std::size_t index, int component) {
  const unsigned char* const first = elements.first + index * elements.stride;
  switch (elements.component) {
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return loaded<float>(first + static_cast<std::size_t>(component) * sizeof(float));
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return integer_at<std::int8_t>(first, component, elements.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return integer_at<std::uint8_t>(first, component, elements.normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return integer_at<std::int16_t>(first, component, elements.normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return integer_at<std::uint16_t>(first, component, elements.normalized);
    default:
      return integer_at<std::uint32_t>(first, component, elements.normalized);
  }
}

class MeshReader {
 public:
  explicit MeshReader(const std::filesystem::path& path) : file_(path, GltfUse::mesh), path_(path.string()) {}

  TriangleSoup read() {
    const tinygltf::Model& model = file_.contents();
    if (model.extensions.contains(kLumigraphExtension)) return read_model();
    shown_.resize(model.nodes.size(), false);
    std::vector<Placed> open;
    for (const int node : roots()) open.push_back({node, glm::dmat4(1)});
    while (!open.empty()) {  // a call per level could end the stack
      const Placed next = open.back();
      open.pop_back();
      show(next, open);
    }
    if (model.nodes.empty()) {
      for (std::size_t mesh = 0; mesh < model.meshes.size(); ++mesh) add_mesh(static_cast<int>(mesh), glm::dmat4(1));
    }
    return finished();
  }

 private:
  TriangleSoup read_model() {
    const std::vector<double> offset =
        file_.numbers(file_.extension(kLumigraphExtension), kLumigraphExtension, "offset", 3);
    (void)file_.triangles();
    add_mesh(0, glm::translate(glm::dmat4(1), glm::dvec3(offset[0], offset[1], offset[2])));
    return finished();
  }

  TriangleSoup finished() {
    if (soup_.faces.empty()) throw no_faces(path_);
    if (!all_colored_) soup_.colors.clear();
    return std::move(soup_);
  }

  struct Placed {
    int node;
    glm::dmat4 scene_from_parent;
  };

  [[nodiscard]] std::vector<int> roots() const {
    const tinygltf::Model& model = file_.contents();
    if (!model.scenes.empty()) {
      const int scene = std::max(model.defaultScene, 0);
      if (static_cast<std::size_t>(scene) >= model.scenes.size()) file_.refuse("its default scene does not exist");
      return model.scenes[static_cast<std::size_t>(scene)].nodes;
    }
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const tinygltf::Node& node : model.nodes) {
      for (const int child : node.children) {
        if (child >= 0 && static_cast<std::size_t>(child) < is_child.size()) {
          is_child[static_cast<std::size_t>(child)] = true;
        }
      }
    }
    std::vector<int> result;
    for (std::size_t i = 0; i < is_child.size(); ++i) {
      if (!is_child[i]) result.push_back(static_cast<int>(i));
    }
    return result;
  }

  void show(const Placed& placed, std::vector<Placed>& open) {
    const tinygltf::Model& model = file_.contents();
    const std::string where = "node " + std::to_string(placed.node);
    if (placed.node < 0 || static_cast<std::size_t>(placed.node) >= model.nodes.size()) {
      file_.refuse(where + " does not exist");
    }
    const auto index = static_cast<std::size_t>(placed.node);
    if (shown_[index]) file_.refuse(where + " hangs on two others, must be part of a tree");
    shown_[index] = true;
    const tinygltf::Node& node = model.nodes[index];
    if (node.skin >= 0) file_.refuse(where + " has a skin, which this program does not read: apply it first");
    if (node.extensions.contains("EXT_mesh_gpu_instancing")) {
      file_.refuse(where + " uses EXT_mesh_gpu_instancing, which this program does not read: write out its instances");
    }
    if (is_hidden(node)) return;
    const glm::dmat4 scene_from_node = placed.scene_from_parent * transform(node, where);
    for (const int child : node.children) open.push_back({child, scene_from_node});
    if (node.mesh >= 0) add_mesh(node.mesh, scene_from_node);
  }

  // A node that KHR_node_visibility hides shows neither its mesh nor its children.
  [[nodiscard]] static bool is_hidden(const tinygltf::Node& node) {
    const auto found = node.extensions.find("KHR_node_visibility");
    if (found == node.extensions.end() || !found->second.Has("visible")) return false;
    const tinygltf::Value& visible = found->second.Get("visible");
    return visible.IsBool() && !visible.Get<bool>();
  }

  // `values` has `count` finite numbers, or none, in which case `otherwise` is taken.
  [[nodiscard]] std::vector<double> numbers(const std::vector<double>& values, std::vector<double> otherwise,
                                            const std::string& what) const {
    if (values.empty()) return otherwise;
    const bool finite = std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
    if (values.size() != otherwise.size() || !finite) {
      file_.refuse(what + " must be " + std::to_string(otherwise.size()) + " finite numbers");
    }
    return values;
  }

  // A matrix by columns, or translation * rotation * scale.
  [[nodiscard]] glm::dmat4 transform(const tinygltf::Node& node, const std::string& where) const {
    glm::dmat4 result(1);
    if (!node.matrix.empty()) {
      const std::vector<double> m = numbers(node.matrix, std::vector<double>(16), where + ": its matrix");
      for (int i = 0; i < 16; ++i) result[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
      return result;
    }
    const std::vector<double> t = numbers(node.translation, {0, 0, 0}, where + ": its translation");
    const std::vector<double> r = numbers(node.rotation, {0, 0, 0, 1}, where + ": its rotation");
    const std::vector<double> s = numbers(node.scale, {1, 1, 1}, where + ": its scale");
    const glm::dquat rotation(r[3], r[0], r[1], r[2]);
    if (!(glm::length(rotation) > 0)) file_.refuse(where + ": its rotation is no quaternion of length 1");
    const glm::dmat3 turn = glm::mat3_cast(glm::normalize(rotation));
    for (int axis = 0; axis < 3; ++axis) result[axis] = glm::dvec4(turn[axis] * s[static_cast<std::size_t>(axis)], 0);
    result[3] = glm::dvec4(t[0], t[1], t[2], 1);
    return result;
  }

  void add_mesh(int index, const glm::dmat4& scene_from_mesh) {
    const tinygltf::Model& model = file_.contents();
    const std::string where = "mesh " + std::to_string(index);
    if (static_cast<std::size_t>(index) >= model.meshes.size()) file_.refuse(where + " does not exist");
    const tinygltf::Mesh& mesh = model.meshes[static_cast<std::size_t>(index)];
    for (std::size_t i = 0; i < mesh.primitives.size(); ++i) {
      const tinygltf::Primitive& primitive = mesh.primitives[i];
      const bool is_surface = primitive.mode >= TINYGLTF_MODE_TRIANGLES && primitive.mode <= TINYGLTF_MODE_TRIANGLE_FAN;
      const std::string what = where + ", primitive " + std::to_string(i);
      if (!primitive.targets.empty()) {
        file_.refuse(what + " has morph targets, which this program does not read: apply them first");
      }
      if (is_surface) add_primitive(primitive, what, scene_from_mesh);
    }
  }

  void add_primitive(const tinygltf::Primitive& primitive, const std::string& what, const glm::dmat4& scene_from_mesh) {
    const auto position = primitive.attributes.find("POSITION");
    if (position == primitive.attributes.end()) file_.refuse(what + " has no POSITION");
    const GltfElements points = file_.elements(position->second, what + ": POSITION");
    if (points.components != 3) file_.refuse(what + ": POSITION is not of three numbers");
    const std::vector<std::uint32_t> corners = corners_of(primitive, what, points.count);
    require_room(points.count, corners.size());
    const auto base = static_cast<std::uint32_t>(soup_.positions.size());
    for (std::size_t i = 0; i < points.count; ++i) {
      const glm::dvec4 p(component_at(points, i, 0), component_at(points, i, 1), component_at(points, i, 2), 1);
      soup_.positions.emplace_back(scene_from_mesh * p);
    }
    add_colors(primitive, what, points.count);
    const bool mirrored = glm::determinant(glm::dmat3(scene_from_mesh)) < 0;
    add_faces(corners, primitive.mode, mirrored, base);
  }

  [[nodiscard]] std::vector<std::uint32_t> corners_of(const tinygltf::Primitive& primitive, const std::string& what,
                                                      std::size_t vertices) const {
    if (vertices > std::numeric_limits<std::uint32_t>::max()) file_.refuse(what + " has too many vertices");
    std::vector<std::uint32_t> corners;
    if (primitive.indices < 0) {
      for (std::size_t i = 0; i < vertices; ++i) corners.push_back(static_cast<std::uint32_t>(i));
      return corners;
    }
    const GltfElements indices = file_.elements(primitive.indices, what + ": indices");
    const bool whole = indices.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                       indices.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                       indices.component == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    if (!whole || indices.components != 1 || indices.normalized) {
      file_.refuse(what + ": its indices are not whole numbers without sign");
    }
    for (std::size_t i = 0; i < indices.count; ++i) {
      const double corner = component_at(indices, i, 0);
      if (!(corner < static_cast<double>(vertices))) {
        file_.refuse(what + ": index " + std::to_string(i) + " is " +
                     std::to_string(static_cast<std::uint32_t>(corner)) + ", but there are " +
                     std::to_string(vertices) + " vertices");
      }
      corners.push_back(static_cast<std::uint32_t>(corner));
    }
    return corners;
  }

  void require_room(std::size_t vertices, std::size_t corners) const {
    const std::uint64_t bytes =
        27 * (std::uint64_t{soup_.positions.size()} + vertices) + 12 * (std::uint64_t{soup_.faces.size()} + corners);
    if (bytes <= kAlwaysAllowed + kMostGrowth * file_.buffer_bytes() + kMostDecodedGrowth * file_.decoded_size()) {
      return;
    }
    file_.refuse("its nodes show its meshes too often: write fewer copies, or another form");
  }

  void add_colors(const tinygltf::Primitive& primitive, const std::string& what, std::size_t vertices) {
    auto found = primitive.attributes.find(kColorAttribute);
    // Beside a texture, models of this program have them under a name that no viewer multiplies with it.
    if (found == primitive.attributes.end()) found = primitive.attributes.find(kTexturedColorAttribute);
    all_colored_ = all_colored_ && found != primitive.attributes.end();
    if (!all_colored_) return;
    const GltfElements colors = file_.elements(found->second, what + ": " + found->first);
    if (found->first == kTexturedColorAttribute && colors.components < 3) {  // some other program's
      all_colored_ = false;
      return;
    }
    if (colors.components < 3 || colors.components > 4 || colors.count != vertices) {
      file_.refuse(what + ": " + found->first + " must be of three or four numbers for each of " +
                   std::to_string(vertices) + " vertices");
    }
    for (std::size_t i = 0; i < vertices; ++i) {
      glm::u8vec3& color = soup_.colors.emplace_back();
      for (int c = 0; c < 3; ++c) {
        const double linear = component_at(colors, i, c);
        color[c] = std::isfinite(linear) ? srgb8_from_linear(linear) : std::uint8_t{0};
      }
    }
  }

  void add_faces(const std::vector<std::uint32_t>& corners, int mode, bool mirrored, std::uint32_t base) {
    const std::size_t step = mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1;
    for (std::size_t i = 0; i + 2 < corners.size(); i += step) {
      glm::uvec3 face(corners[i], corners[i + 1], corners[i + 2]);
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN) face.x = corners[0];
      if (mirrored != (mode == TINYGLTF_MODE_TRIANGLE_STRIP && i % 2 == 1)) std::swap(face.y, face.z);
      soup_.faces.push_back(face + base);
    }
  }

  GltfFile file_;
  std::string path_;
  std::vector<bool> shown_;
  bool all_colored_ = true;
  TriangleSoup soup_;
};

}  // namespace

TriangleSoup read_gltf_mesh(const std::filesystem::path& path) {
  return MeshReader(path).read();
}

}  // namespace lumatlas
