// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/python/scene_arrays.h"

#include <pybind11/stl.h>

#include <filesystem>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/readers/mesh_file.h"
#include "tools/base/output_folder.h"
#include "tools/python/arrays.h"
#include "tools/scene/forms/colmap/colmap_writer.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
using Items = std::map<std::string, py::object>;  // sorted by name, in byte order

// Returns the text of a str in UTF-8. Python's may hold halves of a pair of code units, which have no UTF-8.
std::string utf8_of(const std::string& argument, const py::object& name) {
  py::ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(name.ptr(), &size);
  if (text == nullptr) {
    PyErr_Clear();
    throw std::invalid_argument(argument + ": has the name " + py::repr(name).cast<std::string>() +
                                ", must be text that UTF-8 can hold");
  }
  return {text, static_cast<std::size_t>(size)};
}

// The items of a mapping, whose names are checked.
Items items_of(const std::string& argument, const py::object& mapping) {
  if (!py::hasattr(mapping, "items")) {
    throw std::invalid_argument(argument + ": is a value of type " +
                                py::type::of(mapping).attr("__name__").cast<std::string>() +
                                ", must be a mapping by the names of the photographs");
  }
  Items items;
  for (const py::handle& item : mapping.attr("items")()) {
    const auto pair = py::reinterpret_borrow<py::sequence>(item);
    const py::object key = pair[0];
    if (!py::isinstance<py::str>(key)) {
      throw std::invalid_argument(argument + ": has a name of type " +
                                  py::type::of(key).attr("__name__").cast<std::string>() + ", must be str");
    }
    const std::string name = utf8_of(argument, key);
    check_name(argument, name);
    items.emplace(name, pair[1]);
  }
  return items;
}

std::string item_text(const std::string& argument, const std::string& name) {
  return argument + "['" + name + "']";
}

void check_names_within(const std::string& argument, const Items& items, const std::string& others_argument,
                        const Items& others) {
  for (const auto& [name, item] : items) {
    if (!others.contains(name)) {
      throw std::invalid_argument(item_text(argument, name) + ": " + others_argument + " has nothing of this name");
    }
  }
}

// A photograph's file cannot be a folder for others.
void check_no_folders(const Items& photographs) {
  for (const auto& [name, item] : photographs) {
    for (Path folder = Path(name).parent_path(); !folder.empty(); folder = folder.parent_path()) {
      if (!photographs.contains(folder.string())) continue;
      throw std::invalid_argument(
          item_text("photographs", name) + ": '" + folder.string() +
          "' is the name of a photograph too and cannot be a folder, name one of them otherwise");
    }
  }
}

std::vector<WrittenView> views_of(const Items& photographs, const Items& cameras) {
  if (photographs.empty()) throw std::invalid_argument("photographs: is empty, must hold at least one");
  check_no_folders(photographs);
  check_names_within("photographs", photographs, "cameras", cameras);
  check_names_within("cameras", cameras, "photographs", photographs);
  std::vector<WrittenView> views;
  for (const auto& [name, camera] : cameras) {
    if (!py::isinstance<Camera>(camera)) {
      throw std::invalid_argument(item_text("cameras", name) + ": is a value of type " +
                                  py::type::of(camera).attr("__name__").cast<std::string>() +
                                  ", must be a lumatlas.Camera");
    }
    views.push_back({name, camera.cast<Camera>()});
  }
  return views;
}

TriangleSoup soup_of(const py::object& vertices, const py::object& faces) {
  if (vertices.is_none() != faces.is_none()) {
    throw std::invalid_argument(std::string(vertices.is_none() ? "vertices is" : "faces is") +
                                " None, but the other is not: give both, or none for a scene without a mesh");
  }
  if (vertices.is_none()) return {};
  TriangleSoup soup;
  soup.positions = points_of("vertices", vertices);
  soup.faces = triangles_of("faces", faces, soup.positions.size());
  return soup;
}

void write_picture(const Path& file, const Photograph& picture) {
  const std::vector<std::uint8_t> bytes = encode_image(picture, {ImageFormat::png});
  std::filesystem::create_directories(file.parent_path());
  AtomicFile output(file);
  output.stream().write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  output.commit();
}

// Takes pictures from Python with its lock and writes them without.
template <typename Picture>
void write_pictures(const std::string& argument, const Items& items, const std::vector<WrittenView>& views,
                    const Picture& picture_of, const std::function<Path(const std::string&)>& file_of) {
  for (const WrittenView& view : views) {
    const auto found = items.find(view.name);
    if (found == items.end()) continue;
    const Photograph picture = picture_of(item_text(argument, view.name), found->second, view.camera);
    const py::gil_scoped_release unlocked;
    write_picture(file_of(view.name), picture);
  }
}

void write_soup(const Path& file, const TriangleSoup& soup) {
  if (soup.positions.empty()) return;
  AtomicFile output(file);
  write_ply(output.stream(), soup);
  output.commit();
}

}  // namespace

Scene scene_of_arrays(const py::object& photographs, const py::object& cameras, const py::object& vertices,
                      const py::object& faces, const py::object& masks, const py::object& points) {
  const Items pictures = items_of("photographs", photographs);
  const std::vector<WrittenView> views = views_of(pictures, items_of("cameras", cameras));
  const Items some_masks = masks.is_none() ? Items() : items_of("masks", masks);
  check_names_within("masks", some_masks, "photographs", pictures);
  const TriangleSoup soup = soup_of(vertices, faces);
  TriangleSoup cloud;
  if (!points.is_none()) cloud.positions = points_of("points", points);
  const Path temporary = std::filesystem::temp_directory_path();
  remove_leftovers(temporary);
  auto folder = std::make_shared<TemporaryEntry>(TemporaryEntry::Kind::folder, temporary,
                                                 [] { return random_temporary_name("-scene"); });
  const Path path = folder->path();
  write_pictures("photographs", pictures, views, photograph_of,
                 [&](const std::string& name) { return path / "images" / name; });
  write_pictures("masks", some_masks, views, mask_picture,
                 [&](const std::string& name) { return path / "masks" / (name + ".png"); });
  const py::gil_scoped_release unlocked;
  std::filesystem::create_directories(path / "sparse");
  write_colmap_model(path / "sparse", views, {});
  write_soup(path / "mesh.ply", soup);
  write_soup(path / "fused.ply", cloud);
  return {path, {}, read_scene_views(path, glm::dvec3(0)), std::move(folder)};
}

}  // namespace lumatlas::python
