// SPDX-License-Identifier: GPL-3.0-or-later
// make_corpus FOLDER: the inputs of tests/fuzz/corpus that are not made by hand. Small ones: what matters is that each
// kind of record and each coding of pixels is there once.
#include <OpenImageIO/imageio.h>
#include <lcms2.h>

#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>

#include "atlas/model/model_file.h"
#include "tests/support/profiled_pictures.h"
#include "tests/support/scenes/plain_model.h"
#include "tests/support/scenes/wall_scenes.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace {

namespace fs = std::filesystem;
using namespace lumatlas;

void write_bytes(const fs::path& file, const std::string& bytes) {
  fs::create_directories(file.parent_path());
  if (!(std::ofstream(file, std::ios::binary) << bytes)) throw std::runtime_error(file.string() + ": not written");
}

struct ImageKind {
  const char* name;
  OIIO::TypeDesc type;
  int channels;
  std::map<std::string, std::string> attributes;
};

void write_images(const fs::path& folder) {
  fs::create_directories(folder);
  const std::vector<ImageKind> kinds{
      {"colour.jpg", OIIO::TypeDesc::UINT8, 3, {}},
      {"progressive.jpg", OIIO::TypeDesc::UINT8, 3, {{"jpeg:progressive", "1"}}},
      {"grey.jpg", OIIO::TypeDesc::UINT8, 1, {}},
      {"colour.png", OIIO::TypeDesc::UINT8, 3, {}},
      {"alpha16.png", OIIO::TypeDesc::UINT16, 4, {}},
      {"grey.png", OIIO::TypeDesc::UINT8, 1, {}},
      {"plain.tif", OIIO::TypeDesc::UINT8, 3, {{"compression", "none"}}},
      {"lzw.tif", OIIO::TypeDesc::UINT16, 3, {{"compression", "lzw"}}},
      {"zip.tif", OIIO::TypeDesc::FLOAT, 3, {{"compression", "zip"}, {"planarconfig", "separate"}}},
      {"zip.exr", OIIO::TypeDesc::HALF, 3, {{"compression", "zip"}}},
      {"piz.exr", OIIO::TypeDesc::FLOAT, 4, {{"compression", "piz"}}},
      {"colour.webp", OIIO::TypeDesc::UINT8, 3, {}},
  };
  for (const ImageKind& kind : kinds) {
    OIIO::ImageSpec spec(12, 8, kind.channels, kind.type);
    for (const auto& [key, value] : kind.attributes) spec.attribute(key, value);
    spec.attribute("Orientation", 6);
    std::vector<float> pixels;
    for (int value = 0; value < 12 * 8 * kind.channels; ++value) {
      pixels.push_back(static_cast<float>(value % 97) / 97);
    }
    const fs::path file = folder / kind.name;
    const auto output = OIIO::ImageOutput::create(file.string());
    if (!output || !output->open(file.string(), spec) || !output->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) ||
        !output->close()) {
      throw std::runtime_error(file.string() + ": not written");
    }
    std::string name = kind.name;  // no picture's name: these are not for looking at
    name[name.find('.')] = '-';
    fs::rename(file, folder / name);
  }
}

std::string srgb_profile() {
  cmsHPROFILE profile = cmsCreate_sRGBProfile();
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  std::string bytes(size, '\0');
  if (!cmsSaveProfileToMem(profile, bytes.data(), &size)) throw std::runtime_error("a profile cannot be made");
  cmsCloseProfile(profile);
  return bytes;
}

void write_profiles(const fs::path& folder) {
  const std::string profile = srgb_profile();
  write_bytes(folder / "profile" / "srgb", profile);
  write_bytes(folder / "image" / "profile-png", png_with_profile(profile));
  write_bytes(folder / "image" / "profile-tif", tiff_with_profile(profile));
  write_bytes(folder / "image" / "profile-big-tif", tiff_with_profile(profile, ByteOrder::big, true));
}

void write_models(const fs::path& folder) {
  const fs::path scratch = folder / "scratch";
  fs::create_directories(scratch);
  const Snapshot snapshot = small_snapshot();
  write_model(scratch, snapshot, {});
  make_one_gltf(scratch);
  write_bytes(folder / "model_folder" / "small",
              bytes_of(scratch / "scene.gltf") + '\0' + bytes_of(scratch / "scene.bin"));
  fs::create_directories(folder / "model");
  std::ofstream png(folder / "model" / "png.glb", std::ios::binary);
  write_glb(png, snapshot, {});
  std::ofstream jpeg(folder / "model" / "jpeg.glb", std::ios::binary);
  write_glb(jpeg, snapshot, {}, {.photographs = {ImageFormat::jpeg, 80}}, R"({"options": {"seed": 1}})");
  const BaseTexture texture = small_texture(*snapshot.surface);
  std::ofstream textured(folder / "model" / "textured.glb", std::ios::binary);
  write_glb(textured, snapshot, {}, {.texture = &texture});
  png.close();
  jpeg.close();
  textured.close();
  // A frame's header has 20 bytes, a chunk's 8: the form that fuzz_model puts into a frame itself.
  const std::string glb = bytes_of(folder / "model" / "png.glb");
  std::uint32_t json_bytes = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    json_bytes |= static_cast<std::uint32_t>(static_cast<unsigned char>(glb.at(12 + i))) << (8 * i);
  }
  write_bytes(folder / "model" / "unframed", glb.substr(20, json_bytes) + '\0' + glb.substr(28 + json_bytes));
  fs::remove_all(scratch);
}

void write_colmap(const fs::path& folder) {
  const fs::path scratch = folder / "scratch";
  fs::create_directories(scratch);
  const std::vector<WrittenView> views{{"a.jpg", forward_camera(24, 16)},
                                       {"left/b.jpg", oblique_camera(20, 18, 0.3, {1, 2, 3})}};
  const std::vector<TrackedPoint> points{{{0, 0, 4}, {1, 2, 3}, {{0, {3, 4}}, {1, {5, 6}}}}};
  write_colmap_model(scratch, views, points);
  // The first byte chooses the reader, see fuzz_colmap.cpp.
  write_bytes(folder / "colmap" / "cameras.bin", '\0' + bytes_of(scratch / "cameras.bin"));
  write_bytes(folder / "colmap" / "images.bin", '\1' + bytes_of(scratch / "images.bin"));
  fs::remove_all(scratch);
}

}  // namespace

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::cerr << "usage: make_corpus FOLDER\n";
    return 2;
  }
  try {
    const fs::path folder = arguments[1];
    write_images(folder / "image");
    write_profiles(folder);
    write_models(folder);
    write_colmap(folder);
    for (const char* name : {"colour-jpg", "grey-jpg", "colour-png"}) {
      write_bytes(folder / "image_header" / name, bytes_of(folder / "image" / name));
    }
  } catch (const std::exception& error) {
    std::cerr << "make_corpus: " << error.what() << '\n';
    return 1;
  }
  return 0;
}
