// SPDX-License-Identifier: GPL-3.0-or-later
// The readers of captures that are not COLMAP's or transforms.json. The first letter says which; a zero byte stands
// between the files of those that read several.
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tests/fuzz/laws/capture_laws.h"
#include "tests/fuzz/laws/sentence_laws.h"
#include "tools/scene/forms/photogrammetry/bundler.h"
#include "tools/scene/forms/photogrammetry/meshroom.h"
#include "tools/scene/forms/photogrammetry/metashape.h"
#include "tools/scene/forms/photogrammetry/openmvg.h"
#include "tools/scene/forms/photogrammetry/openmvs.h"
#include "tools/scene/forms/photogrammetry/opensfm.h"
#include "tools/scene/forms/photogrammetry/reality_capture.h"
#include "tools/scene/forms/photogrammetry/visual_sfm.h"
#include "tools/scene/forms/photographs/photograph_lookup.h"
#include "tools/scene/forms/photographs/photograph_names.h"
#include "tools/scene/forms/polycam.h"
#include "tools/scene/forms/scannet.h"
#include "tools/scene/forms/tum_rgbd.h"

namespace {

using namespace lumatlas;

ImageSize size_of(const PosedPhotograph&) {
  return {640, 480};
}

std::vector<std::string> files_in(std::string_view text) {
  std::vector<std::string> files;
  while (true) {
    const std::size_t zero = text.find('\0');
    files.emplace_back(text.substr(0, zero));
    if (zero == std::string_view::npos) return files;
    text.remove_prefix(zero + 1);
  }
}

std::optional<std::string> given(const std::string& file) {
  return file.empty() ? std::nullopt : std::optional(file);
}

Capture parse(char form, std::string_view text) {
  const PhotographNames names({"a.jpg", "b/c.png"});
  const PhotographLookup lookup{[&](std::string_view label) {
                                  PosedPhotograph photograph{names.find(std::string(label))};
                                  if (photograph.name.empty()) photograph.name = "none";
                                  return photograph;
                                },
                                size_of};
  std::vector<std::string> files = files_in(text);
  std::vector<std::pair<std::string, std::string>> rest;
  for (std::size_t i = 1; i < files.size(); ++i) rest.emplace_back(std::to_string(i), files[i]);
  switch (form) {
    case 'T':
      files.resize(4);
      return parse_tum({"freiburg1", files[0], files[1], given(files[2]), given(files[3])}, size_of);
    case 'S':
      return parse_scannet({"scene", files[0], rest}, size_of);
    case 'R':
      return parse_reality_capture(text, "cameras.csv", lookup);
    case 'M':
      return parse_metashape(text, "cameras.xml", lookup);
    case 'F':
      return parse_opensfm(text, "reconstruction.json", lookup);
    case 'G':
      return parse_openmvg(text, "sfm_data.json", lookup);
    case 'H':
      return parse_meshroom(text, "cameras.sfm", lookup);
    case 'N':
      return parse_visual_sfm(text, "scene.nvm", lookup);
    case 'B':
      files.resize(2);
      return parse_bundler(files[0], "bundle.out", files[1], "list.txt", lookup);
    case 'P':
      return parse_polycam(
          {"cameras", rest, "mesh_info.json", files[0].empty() ? std::nullopt : std::optional(files[0])},
          [](const std::string& id) { return PosedPhotograph{id}; });
    default:
      return parse_openmvs(std::as_bytes(std::span(text)), "scene.mvs", lookup);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  check_refusal([&] {
    const Capture read = parse(static_cast<char>(data[0]), text_of(data + 1, size - 1));
    require(!read.photographs.empty());
    for (const PosedPhotograph& photograph : read.photographs) {
      check(photograph.lens);
      require(!photograph.name.empty() && !photograph.file.is_absolute());
      require(std::abs(glm::length(photograph.cam_from_world_rotation) - 1) < 1e-9);
      require(std::isfinite(glm::length(photograph.cam_from_world_translation)));
    }
    require_inside(read);
    for (const PosedDepth& depth : read.depths) {
      check(depth.lens);
      require(depth.unit > 0 && std::isfinite(depth.unit) && !depth.file.is_absolute());
    }
  });
  return 0;
}
