// SPDX-License-Identifier: GPL-3.0-or-later
#include "blend/gl/mesh_objects.h"

#include <cstdint>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>

#include "blend/gl/egl_context.h"

namespace lumatlas {

void make_vertices(MeshObjects& objects) {
  GLuint name = 0;
  glGenVertexArrays(1, &name);
  objects.vertices = GlVertexArray(name);
  glBindVertexArray(name);
  glBindBuffer(GL_ARRAY_BUFFER, objects.positions.get());
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(glm::vec3), nullptr);
  glBindBuffer(GL_ARRAY_BUFFER, objects.colors.get());
  glVertexAttribPointer(1, 3, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(glm::u8vec3), nullptr);
  glBindBuffer(GL_ARRAY_BUFFER, objects.shares.get());
  glVertexAttribPointer(2, 3, GL_UNSIGNED_SHORT, GL_TRUE, sizeof(glm::u16vec4), nullptr);
  glBindBuffer(GL_ARRAY_BUFFER, objects.zone_numbers.get());
  glVertexAttribIPointer(3, 1, GL_UNSIGNED_INT, sizeof(std::uint32_t), nullptr);
  for (const GLuint attribute : {0u, 1u, 2u, 3u}) glEnableVertexAttribArray(attribute);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, objects.faces.get());
  glBindVertexArray(0);
  check_gl("loading the mesh");
}

MeshObjects make_mesh_objects(const ZoneMesh& mesh) {
  MeshObjects objects{make_buffer(mesh.positions), make_buffer(mesh.colors), make_buffer(mesh.shares),
                      make_buffer(mesh.zones),     make_buffer(mesh.faces),  {}};
  make_vertices(objects);
  return objects;
}

}  // namespace lumatlas
