// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/scene/forms/capture_forms.h"

#include <array>
#include <system_error>

#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/forms/panorama.h"
#include "tools/scene/forms/photogrammetry/bundler.h"
#include "tools/scene/forms/photogrammetry/meshroom.h"
#include "tools/scene/forms/photogrammetry/metashape.h"
#include "tools/scene/forms/photogrammetry/openmvg.h"
#include "tools/scene/forms/photogrammetry/openmvs.h"
#include "tools/scene/forms/photogrammetry/opensfm.h"
#include "tools/scene/forms/photogrammetry/reality_capture.h"
#include "tools/scene/forms/photogrammetry/visual_sfm.h"
#include "tools/scene/forms/photographs/find_photographs.h"
#include "tools/scene/forms/polycam.h"
#include "tools/scene/forms/scannet.h"
#include "tools/scene/forms/transforms_json.h"
#include "tools/scene/forms/tum_rgbd.h"

namespace lumatlas {

namespace {

namespace fs = std::filesystem;

std::optional<fs::path> find_colmap(const fs::path& scene) {
  if (std::optional<fs::path> images = find_colmap_images(scene)) return images;
  std::error_code ignored;  // one that lacks a file is refused by what it lacks
  for (const fs::path& folder : {scene / "sparse", scene / "sparse" / "0", scene}) {
    for (const char* const images : {"images.bin", "images.txt"}) {
      if (fs::exists(folder / images, ignored)) return folder / images;
    }
  }
  return std::nullopt;
}

struct Reader {
  const char* name;
  std::optional<fs::path> (*find)(const fs::path& scene);
  decltype(CaptureForm::read) read;
};

constexpr std::array kReaders{
    Reader{"COLMAP", find_colmap, read_colmap},
    Reader{"transforms.json", find_transforms, read_transforms},
    Reader{"Polycam", find_polycam, read_polycam},
    Reader{"Metashape", find_metashape, read_metashape},
    Reader{"RealityCapture", find_reality_capture, read_reality_capture},
    Reader{"OpenMVS", find_openmvs, read_openmvs},
    Reader{"OpenSfM", find_opensfm, read_opensfm},
    Reader{"OpenMVG", find_openmvg, read_openmvg},
    Reader{"Meshroom", find_meshroom, read_meshroom},
    Reader{"VisualSFM", find_visual_sfm, read_visual_sfm},
    Reader{"Bundler", find_bundler, read_bundler},
    Reader{"ScanNet", find_scannet, read_scannet},
    Reader{"TUM RGB-D", find_tum, read_tum},
};

}  // namespace

std::vector<CaptureForm> forms_in(const fs::path& scene) {
  std::vector<CaptureForm> forms;
  for (const Reader& reader : kReaders) {
    if (const std::optional<fs::path> file = reader.find(scene)) forms.push_back({reader.name, *file, reader.read});
  }
  return forms;
}

Capture read_capture(const CaptureRequest& request) {
  const std::vector<CaptureForm> forms = forms_in(request.scene);
  if (forms.empty()) return read_colmap(request);  // says what is missing
  const CaptureForm& form = forms.front();
  Capture capture = form.read(request);
  capture.form = form.name;
  capture.file = form.file;
  find_photographs(capture, form.file, request.scene, request.images, request.bad);
  cut_panoramas(capture);
  if (std::string note = other_forms_note(forms); !note.empty()) capture.notes.push_back(std::move(note));
  return capture;
}

std::string other_forms_note(const std::vector<CaptureForm>& forms) {
  if (forms.size() < 2) return {};
  std::string others;
  for (std::size_t i = 1; i < forms.size(); ++i) others += (i == 1 ? "" : ", ") + forms[i].file.string();
  return "the scene is read from " + forms[0].file.string() + ", and not from what lies beside it: " + others;
}

}  // namespace lumatlas
