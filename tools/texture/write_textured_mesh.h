// SPDX-License-Identifier: GPL-3.0-or-later
// A textured mesh as files that other programs read: glTF 2.0 (with KHR_materials_unlit, for the light is in the
// photographs), as a folder or one .glb, and Wavefront OBJ.
//
// Vertices are where they are in the model; only those on the outline of a chart are there twice, at one place, so
// that no edge has a vertex in its middle. Faces keep their turn.
#pragma once

#include <filesystem>
#include <glm/mat3x3.hpp>
#include <iosfwd>
#include <span>
#include <string>

#include "mesh/camera/camera.h"
#include "tools/texture/layout/page_image.h"
#include "tools/texture/textured_mesh.h"

namespace lumatlas {

// The generator that glTF files of an export name. A model of `build` names "lumatlas".
inline constexpr const char* kExportGenerator = "lumatlas export";

struct TexturedFileOptions {
  // The coding of the pages. WebP is for glTF alone (std::invalid_argument), by EXT_texture_webp, which a reader must
  // know then.
  PageCoding image;
  // The rotation from the scene's frame to the file's: orthonormal, determinant 1 (std::invalid_argument). glTF has it
  // as the root node's rotation, with a camera for each stored view below, an OBJ's vertices are turned.
  glm::dmat3 file_from_scene{1.0};
  std::string notes;  // glTF's asset.extras: the text of a JSON object, or empty
  // The position of the file's coordinates on the Earth. glTF has the text of a JSON object as "georeference" in its
  // root node's extras; an OBJ has the sentence, without line breaks, as a comment. Empty: not known.
  std::string georeference, georeference_sentence;
};

// `cancel_check` is as of TexturedMesh::bake(). All throw InputError where a file cannot be written, or an image not be
// encoded. scene.gltf, scene.bin and texture-0.png ... in `folder`, which must exist.
TextureFacts write_textured_gltf(const std::filesystem::path& folder, const TexturedMesh& mesh,
                                 const TexturedFileOptions& options, const CancelCheck& cancel_check = {});
// The caller looks whether the stream has failed. Holds the encoded file in memory. InputError from 4 GiB on.
TextureFacts write_textured_glb(std::ostream& file, const TexturedMesh& mesh, const TexturedFileOptions& options,
                                const CancelCheck& cancel_check = {});
// scene.obj, scene.mtl and texture-0.png ... in `folder`, which must exist. The scene's offset is added before it is
// turned.
TextureFacts write_textured_obj(const std::filesystem::path& folder, const TexturedMesh& textured,
                                const TexturedFileOptions& options, const CancelCheck& cancel_check = {});

}  // namespace lumatlas
