// SPDX-License-Identifier: GPL-3.0-or-later
#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "blend/tables/tiles.h"
#include "tools/base/output_folder.h"
#include "tools/picture/frame_renderer.h"
#include "tools/picture/model_tour.h"
#include "tools/picture/picture_output.h"
#include "tools/python/arrays.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/model.h"
#include "tools/python/names.h"
#include "tools/python/pictures.h"
#include "tools/python/progress.h"

namespace lumatlas::python {

namespace py = pybind11;

namespace {

using Path = std::filesystem::path;
using Range = std::optional<std::pair<double, double>>;
using Cameras = std::variant<std::map<std::string, Camera>, std::vector<Camera>>;

constexpr std::array<std::pair<const char*, PictureFormat>, 3> kPictureForms{
    {{"png", PictureFormat::png}, {"exr", PictureFormat::exr}, {"mp4", PictureFormat::mp4}}};
constexpr std::array<std::pair<const char*, TourOptions::Kind>, 3> kTours{
    {{"orbit", TourOptions::Kind::orbit}, {"walk", TourOptions::Kind::walk}, {"hilbert", TourOptions::Kind::hilbert}}};

FrameOptions frame_options(const std::string& mode, const std::optional<std::string>& background,
                           const Range& value_range, bool color_bar, bool draft) {
  FrameOptions options;
  options.mode = value_named(kModesByName, "mode", mode);
  if (draft) options.blend = BlendOptions::draft();
  options.color_bar = color_bar && options.mode != Mode::picture;
  if (background) {
    if (options.mode != Mode::picture) throw std::invalid_argument("background is for the mode picture, not " + mode);
    const std::optional<Background> named = background_named(*background);
    if (!named) {
      throw std::invalid_argument("background is '" + *background + "', must be alpha, blur, black, white or #rrggbb");
    }
    options.background = *named;
  }
  if (!value_range) return options;
  if (!has_range(options.mode)) throw std::invalid_argument("value_range: the mode " + mode + " has none");
  options.range = ValueRange{value_range->first, value_range->second};
  return options;
}

// Draws frames of a model, whose cameras are in the scene's coordinates. Needs no lock of Python's.
void draw_frames(Model& model, const FrameOptions& options, bool with_far_sphere,
                 const std::function<void(FrameRenderer&)>& drawing) {
  if (needs_renderer(options.mode)) {
    model.draw(with_far_sphere, [&](const Snapshot& snapshot, Renderer& renderer) {
      FrameRenderer frames(snapshot, options, &renderer);
      drawing(frames);
    });
    return;
  }
  FrameRenderer frames(model.model().snapshot, options, nullptr);
  drawing(frames);
}

// The photograph that the mode error needs; none for the others.
std::optional<Photograph> photograph_to_compare(Mode mode, const py::object& photograph, const Camera& camera) {
  if (mode != Mode::error) {
    if (!photograph.is_none()) throw std::invalid_argument("photograph is for the mode error alone");
    return std::nullopt;
  }
  if (photograph.is_none()) throw std::invalid_argument("photograph is None, but the mode error compares with one");
  return photograph_of("photograph", photograph, camera);
}

Rendering plain_picture(Model& model, const Camera& camera, const BlendOptions& blend) {
  check_picture_size(camera);
  Rendering rendering;
  model.draw(true, [&](const Snapshot&, Renderer& renderer) {
    rendering = render_tiled(renderer, in_model(camera, model.offset()), blend);
  });
  return rendering;
}

// Colours, and their alpha where there is one.
py::array_t<std::uint8_t> soft_picture_array(SoftPicture soft) {
  if (soft.alpha.empty()) return picture_array(std::move(soft.picture));
  std::vector<std::uint8_t> rgba(4 * soft.alpha.size());
  for (std::size_t i = 0; i < soft.alpha.size(); ++i) {
    std::copy_n(soft.picture.rgb.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, &rgba[4 * i]);
    rgba[4 * i + 3] = soft.alpha[i];
  }
  return array_of(std::move(rgba), {py::ssize_t{soft.picture.height}, py::ssize_t{soft.picture.width}, 4});
}

py::array_t<std::uint8_t> render(Model& model, const Camera& camera, const std::string& mode,
                                 const std::optional<std::string>& background, const Range& value_range, bool color_bar,
                                 bool draft, const py::object& photograph) {
  check_picture_size(camera);
  const FrameOptions options = frame_options(mode, background, value_range, color_bar, draft);
  const std::optional<Photograph> compared = photograph_to_compare(options.mode, photograph, camera);
  SoftPicture picture;
  {
    const py::gil_scoped_release unlocked;
    if (options.mode == Mode::picture && !background) {
      picture.picture = plain_picture(model, camera, options.blend).picture;
    } else {
      draw_frames(model, options, !background, [&](FrameRenderer& frames) {
        picture = frames.picture(in_model(camera, model.offset()), compared ? &*compared : nullptr);
      });
    }
  }
  return soft_picture_array(std::move(picture));
}

py::array_t<float> render_values(Model& model, const Camera& camera, const std::string& mode, bool draft,
                                 const py::object& photograph) {
  check_picture_size(camera);
  const FrameOptions options = frame_options(mode, std::nullopt, std::nullopt, false, draft);
  const std::optional<Photograph> compared = photograph_to_compare(options.mode, photograph, camera);
  FloatImage image;
  {
    const py::gil_scoped_release unlocked;
    draw_frames(model, options, true, [&](FrameRenderer& frames) {
      image = frames.numbers(in_model(camera, model.offset()), compared ? &*compared : nullptr);
    });
  }
  const auto channels = static_cast<py::ssize_t>(image.channels.size());
  return array_of(std::move(image.values), {py::ssize_t{image.height}, py::ssize_t{image.width}, channels});
}

py::tuple render_with_state(Model& model, const Camera& camera) {
  Rendering rendering;
  {
    const py::gil_scoped_release unlocked;
    rendering = plain_picture(model, camera, BlendOptions());
  }
  std::vector<std::uint8_t> states(rendering.state.size());
  std::transform(rendering.state.begin(), rendering.state.end(), states.begin(),
                 [](PixelState state) { return static_cast<std::uint8_t>(state); });
  return py::make_tuple(picture_array(std::move(rendering.picture)),
                        array_of(std::move(states), {py::ssize_t{camera.height}, py::ssize_t{camera.width}}));
}

std::vector<Camera> tour(const Model& model, const std::string& kind, const std::optional<Path>& path,
                         std::size_t frames, std::uint32_t width, std::uint32_t height, double fov_deg, bool anywhere) {
  TourOptions options;
  options.kind = path ? TourOptions::Kind::keys : value_named(kTours, "kind", kind);
  options.path = path.value_or(Path());
  options.frames = frames;
  options.width = width;
  options.height = height;
  options.fov_deg = fov_deg;
  options.anywhere = anywhere;
  const Progress signals("tour", py::none());
  options.cancel_check = [&] { signals.tell("", 0, 0); };
  const py::gil_scoped_release unlocked;
  std::vector<Camera> cameras;
  for (const Vantage& vantage : model_tour(model.model().snapshot, options).vantages) {
    cameras.push_back(in_scene(camera_at(vantage, width, height), model.offset()));
  }
  return cameras;
}

// A camera, and the file of its picture in the output folder.
struct PictureToDraw {
  Camera camera;
  Path file;
};

std::vector<PictureToDraw> pictures_of(const Cameras& cameras, PictureOutput& output) {
  std::vector<PictureToDraw> pictures;
  if (const auto* const named = std::get_if<std::map<std::string, Camera>>(&cameras)) {
    for (const auto& [name, camera] : *named) {
      check_name("cameras", name);
      pictures.push_back({camera, output.file_for_view(name)});
    }
  } else {
    const auto& listed = std::get<std::vector<Camera>>(cameras);
    pictures.reserve(listed.size());
    for (const Camera& camera : listed) {
      pictures.push_back({camera, output.file_for_frame(pictures.size(), listed.size())});
    }
  }
  if (pictures.empty()) throw std::invalid_argument("cameras: is empty, must hold at least one");
  for (const PictureToDraw& picture : pictures) check_picture_size(picture.camera);
  return pictures;
}

void draw_into(PictureOutput& output, PictureFormat format, FrameRenderer& frames, const PictureToDraw& picture,
               const glm::dvec3& offset) {
  const Camera camera = in_model(picture.camera, offset);
  if (format == PictureFormat::exr) {
    output.write(picture.file, frames.numbers(camera, nullptr));
  } else {
    output.write(picture.file, frames.picture(camera, nullptr));
  }
}

std::vector<Path> render_files(Model& model, const Cameras& cameras, const Path& output, const std::string& mode,
                               const std::optional<std::string>& background, const Range& value_range, bool color_bar,
                               bool draft, const std::string& format, double fps, const py::object& progress) {
  FrameOptions options = frame_options(mode, background, value_range, color_bar, draft);
  const PictureFormat form = value_named(kPictureForms, "format", format);
  if (options.mode == Mode::error) {
    throw std::invalid_argument("mode is 'error', which compares with a photograph: call Model.render() with one");
  }
  if (background == "alpha" && form == PictureFormat::mp4) {
    throw std::invalid_argument("background is 'alpha', which a video has not: name blur or a colour");
  }
  if (!(fps >= 0.01 && fps <= 1000)) {
    throw std::invalid_argument("fps is " + std::to_string(fps) + ", must be 0.01 to 1000");
  }
  if (form == PictureFormat::exr && !background) options.background = {Background::Kind::transparent, {}};
  check_apart(output, std::array{model.path()});
  const Progress told("rendering", progress);
  const py::gil_scoped_release unlocked;
  OutputFolder folder(output, "render");
  PictureOutput written(folder.path(), form, fps);
  const std::vector<PictureToDraw> pictures = pictures_of(cameras, written);
  told.tell("rendering", 0, pictures.size());
  draw_frames(model, options, !background, [&](FrameRenderer& frames) {
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      draw_into(written, form, frames, pictures[i], model.offset());
      told.tell("rendering", i + 1, pictures.size());
    }
  });
  written.finish();
  folder.commit({{"command", "render"}, {"model", model.path().string()}, {"mode", mode}, {"format", format}});
  if (form == PictureFormat::mp4) return {output / "video.mp4"};
  std::vector<Path> files;
  files.reserve(pictures.size());
  for (const PictureToDraw& picture : pictures) files.push_back(output / picture.file);
  return files;
}

}  // namespace

void bind_render(py::module_& module) {
  auto model = py::class_<Model, std::shared_ptr<Model>>(module.attr("Model"));
  model
      .def("render", &render, py::arg("camera"), py::kw_only(), py::arg("mode") = "picture",
           py::arg("background") = py::none(), py::arg("value_range") = py::none(), py::arg("color_bar") = false,
           py::arg("draft") = false, py::arg("photograph") = py::none(),
           "The picture from there, or what `lumatlas render --mode` shows: (height, width, 3), sRGB; with alpha 4")
      .def("render_values", &render_values, py::arg("camera"), py::kw_only(), py::arg("mode") = "picture",
           py::arg("draft") = false, py::arg("photograph") = py::none(),
           "The numbers of a mode, NaN where there are none, or linear light: (height, width, channels)")
      .def("render_with_state", &render_with_state, py::arg("camera"),
           "The picture, and why each pixel has its colour: 0 no surface, 1 seen by no photograph, 2 by none that is "
           "stored, 3 from photographs")
      .def("tour", &tour, py::arg("kind") = "orbit", py::kw_only(), py::arg("path") = py::none(),
           py::arg("frames") = 120, py::arg("width") = 1280, py::arg("height") = 720, py::arg("fov_deg") = 70.0,
           py::arg("anywhere") = false,
           "The cameras of a path: orbit, walk or hilbert, or through the key frames of a JSON file");
  module.def("render", &render_files, py::arg("model"), py::arg("cameras"), py::arg("output"), py::kw_only(),
             py::arg("mode") = "picture", py::arg("background") = py::none(), py::arg("value_range") = py::none(),
             py::arg("color_bar") = true, py::arg("draft") = false, py::arg("format") = "png", py::arg("fps") = 30.0,
             py::arg("progress") = py::none(),
             "Write a folder of pictures, one for each camera, or of one video; returns the files");
}

}  // namespace lumatlas::python
