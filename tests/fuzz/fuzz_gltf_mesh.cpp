// SPDX-License-Identifier: GPL-3.0-or-later
// Any glTF file as a mesh: JSON with buffers in it, or a whole .glb.
#include "atlas/model/gltf/gltf_mesh.h"
#include "tests/fuzz/laws/sentence_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lumatlas;
  write_input("mesh.gltf", text_of(data, size));
  check_refusal([] {
    const TriangleSoup soup = read_gltf_mesh("mesh.gltf");
    require(!soup.faces.empty());
    require(soup.colors.empty() || soup.colors.size() == soup.positions.size());
    for (const glm::uvec3& face : soup.faces) {
      for (int corner = 0; corner < 3; ++corner) require(face[corner] < soup.positions.size());
    }
  });
  return 0;
}
