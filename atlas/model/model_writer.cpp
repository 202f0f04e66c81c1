// SPDX-License-Identifier: GPL-3.0-or-later
#include <tbb/parallel_for.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <regex>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <unordered_set>
#include <utility>

#include "atlas/model/content_digest.h"
#include "atlas/model/gltf/glb_file.h"
#include "atlas/model/gltf/gltf_cameras.h"
#include "atlas/model/gltf/json_nesting.h"
#include "atlas/model/model_document.h"
#include "atlas/model/model_file.h"
#include "atlas/model/model_images.h"
#include "atlas/model/model_parts.h"
#include "atlas/model/surface/coarse_surface.h"
#include "mesh/base/errors.h"
#include "mesh/base/temporary_entry.h"

namespace lumatlas {

namespace {

// Returns whether a file's name is one that name_by_content() makes.
bool is_name_by_content(const std::filesystem::path& file) {
  static const std::regex by_content(".*-[0-9a-f]{16}\\.(png|jpg|bin|glb)");
  return std::regex_match(file.filename().string(), by_content);
}

// The files of a model's folder. All are written into a temporary folder in it before the first takes its place. None
// of them replaces a file of other content but tileset.json, which comes last: the folder holds the earlier model until
// then and the new one from then on, whenever the process or the machine stops. One folder instead of one pending file
// each: a pending file keeps a descriptor open, and models have more images than a process may have open files.
class PendingFiles {
 public:
  // Throws InputError unless `folder` exists and can be written to.
  explicit PendingFiles(const std::filesystem::path& folder) : folder_(folder) {
    try {
      temporary_ = std::make_unique<TemporaryEntry>(TemporaryEntry::Kind::folder, folder_,
                                                    [] { return random_temporary_name(); });
    } catch (const std::system_error& error) {
      throw InputError(folder.string() + ": cannot be written to: " + error.code().message());
    }
  }

  // Writes a file under a name of its content, which it returns, relative to the folder. Safe from several threads.
  std::string write(const FormFile& file) {
    return write_as(name_by_content(file.stem, file.ending, file.bytes), file.bytes);
  }

  // Writes tileset.json, as the last.
  void write_tileset(std::span<const std::uint8_t> bytes) { write_as(kTilesetName, bytes); }

  // Puts the files into their places in the order of their numbers, once the disk has them all. Throws InputError; the
  // folder is then as it was.
  void commit() {
    require_on_disk(sync_file_system(folder_));
    const auto paused = removal_paused();
    std::vector<std::filesystem::path> added;
    try {
      for (std::size_t number = 0; number + 1 < names_.size(); ++number) {
        std::error_code ignored;
        const std::filesystem::path file = folder_ / names_[number];
        const bool is_new =
            std::filesystem::symlink_status(file, ignored).type() == std::filesystem::file_type::not_found;
        put_in_place(number);
        if (is_new) added.push_back(file);
      }
      require_on_disk(sync_to_disk(folder_ / kImageFolder) && sync_to_disk(folder_));
      put_in_place(names_.size() - 1);
    } catch (...) {
      std::error_code ignored;
      for (const std::filesystem::path& file : added) std::filesystem::remove(file, ignored);
      throw;
    }
  }

  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }

 private:
  std::string write_as(const std::string& name, std::span<const std::uint8_t> bytes) {
    std::size_t number = 0;
    {
      const std::lock_guard lock(mutex_);
      number = names_.size();
      names_.push_back(name);
    }
    std::ofstream stream(pending(number), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream || std::filesystem::is_directory(folder_ / name)) {
      throw InputError((folder_ / name).string() +
                       ": cannot be written: check that the disk has room and the folder is writable");
    }
    return name;
  }

  void put_in_place(std::size_t number) const {
    std::error_code error;
    std::filesystem::rename(pending(number), folder_ / names_[number], error);
    if (error) throw InputError((folder_ / names_[number]).string() + ": cannot be written: " + error.message());
  }

  void require_on_disk(bool is_on_disk) const {
    if (!is_on_disk) throw InputError(folder_.string() + ": cannot be written: check that the disk has room");
  }

  [[nodiscard]] std::filesystem::path pending(std::size_t number) const {
    return temporary_->path() / std::to_string(number);
  }

  std::filesystem::path folder_;
  std::mutex mutex_;
  std::vector<std::string> names_;  // in the order of their numbers
  std::unique_ptr<TemporaryEntry> temporary_;
};

// The images of a model. They are removed if the model is not completed.
class ImageFolder {
 public:
  explicit ImageFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::error_code error;
    made_ = std::filesystem::create_directories(folder_, error);
    if (error) throw InputError(folder_.string() + ": cannot be made: " + error.message());
  }
  ~ImageFolder() {
    std::error_code ignored;
    if (made_ && !kept_) std::filesystem::remove(folder_, ignored);  // only if it is empty
  }
  ImageFolder(const ImageFolder&) = delete;
  ImageFolder& operator=(const ImageFolder&) = delete;
  void keep() { kept_ = true; }

 private:
  std::filesystem::path folder_;
  bool made_ = false;
  bool kept_ = false;
};

// Files with names by content: those of the model that was written into the folder before, and those that a save leaves
// behind which is cut off before its end.
std::vector<std::string> files_named_by_content(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const std::filesystem::path& part : {std::filesystem::path(), std::filesystem::path(kImageFolder)}) {
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder / part, error), end; !error && entry != end;
         entry.increment(error)) {
      const std::filesystem::path name = part / entry->path().filename();
      const std::string text = name.string();
      const bool is_surface_or_image = !part.empty() || text.starts_with("surface-") || text.starts_with("coarse-");
      if (is_surface_or_image && is_name_by_content(name)) names.push_back(text);
    }
  }
  return names;
}

// Removes those files of earlier saves that are not among the model's files now.
void remove_unused(const std::filesystem::path& folder, std::vector<std::string> of_earlier_saves,
                   const std::unordered_set<std::string>& names) {
  std::erase_if(of_earlier_saves, [&](const std::string& name) { return names.contains(name); });
  for (const std::string& name : of_earlier_saves) {
    std::error_code ignored;
    if (std::filesystem::symlink_status(folder / name, ignored).type() == std::filesystem::file_type::regular) {
      std::filesystem::remove(folder / name, ignored);
    }
  }
}

// tinygltf would leave out what is null in the notes.
nlohmann::json parsed_notes(const std::string& notes) {
  if (nesting(notes) > kMaxNesting) {
    throw std::invalid_argument("model: notes nest their values more than " + std::to_string(kMaxNesting) + " deep");
  }
  nlohmann::json parsed = nlohmann::json::parse(notes, nullptr, false);
  if (!parsed.is_object()) throw std::invalid_argument("model: notes are not the text of a JSON object");
  return parsed;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

// Those of the views, in the model's only buffer.
void add_images(GltfBuilder& gltf, const ModelParts& model) {
  std::vector<std::vector<std::uint8_t>> files(model.images.size());
  tbb::parallel_for(std::size_t{0}, files.size(),
                    [&](std::size_t index) { files[index] = encoded(model.images[index], model.snapshot); });
  for (std::size_t index = 0; index < files.size(); ++index) {
    gltf.add_image(files[index], mime_type(model.images[index].coding.format));
    std::vector<std::uint8_t>().swap(files[index]);
    require_fits_glb(gltf.bytes());
  }
}

// The properties of the surface. The images come last in the buffer: a page asks for the bytes before them first.
nlohmann::json add_surfaces(GltfBuilder& gltf, const ModelParts& model, const FormOptions& options) {
  SurfaceForm form;
  if (options.texture) form.texture = static_cast<int>(model.images.size());
  const WrittenSurface written = written_surface(*model.snapshot.surface, options.shares,
                                                 options.texture ? &options.texture->faces : nullptr, std::nullopt);
  nlohmann::json properties = add_surface(gltf, model.snapshot, written, view_tables(model.snapshot), form);
  if (needs_coarse_surface(model.snapshot.surface->near_faces(), FormOptions{}.coarse_faces)) {
    Mesh near = near_surface(*model.snapshot.surface).mesh;
    const std::vector<glm::u8vec3>& colors = model.snapshot.vertex_colors.get();
    near.colors.assign(colors.begin(), colors.begin() + static_cast<std::ptrdiff_t>(near.positions.size()));
    properties["coarse"] = add_coarse_surface(gltf, coarse_surface(near, FormOptions{}.coarse_faces), std::nullopt);
  }
  return properties;
}

template <typename Given>
void write_files(const std::filesystem::path& folder, const Given& given, const ValidityOptions& validity,
                 const FormOptions& options) {
  check(validity);
  check(options.photographs);
  std::vector<std::string> earlier = files_named_by_content(folder);
  ImageFolder image_folder(folder / kImageFolder);
  PendingFiles files(folder);
  const std::string tileset =
      write_form(given, validity, options, [&](const FormFile& file) { return files.write(file); });
  files.write_tileset(bytes_of(tileset));
  files.commit();
  image_folder.keep();
  // Until the disk has the new tileset.json, a crash may bring the earlier one back, which needs its files.
  if (!sync_to_disk(folder)) return;
  remove_unused(folder, std::move(earlier), {files.names().begin(), files.names().end()});
}

}  // namespace

void write_model(const std::filesystem::path& folder, const Snapshot& given, const ValidityOptions& validity,
                 const FormOptions& options) {
  write_files(folder, given, validity, options);
}

void write_model(const std::filesystem::path& folder, const PiecewiseModel& given, const ValidityOptions& validity,
                 const FormOptions& options) {
  write_files(folder, given, validity, options);
}

void write_glb(std::ostream& file, const Snapshot& given, const ValidityOptions& validity, const FormOptions& options,
               const std::string& notes) {
  const ModelParts model = model_parts(given, validity, options);
  const nlohmann::json extras = notes.empty() ? nlohmann::json() : parsed_notes(notes);
  GltfBuilder gltf(false);
  nlohmann::json properties = add_surfaces(gltf, model, options);
  properties.update(model.properties);
  add_images(gltf, model);
  if (options.texture) {
    const ImageCoding& coding = options.texture->coding;
    gltf.add_image(encode_image(options.texture->image, coding), mime_type(coding.format));
  }
  nlohmann::json& document = gltf.document();
  add_scene(document, gltf_from_scene(model.snapshot));
  add_cameras(document, model.snapshot);
  set_lumigraph(document, std::move(properties));
  if (!notes.empty()) document["asset"]["extras"] = extras;
  const std::vector<std::string> uris{""};
  const std::vector<std::vector<unsigned char>> buffers = gltf.finish(uris);
  write_glb_frame(file, document.dump(), buffers.front());
}

}  // namespace lumatlas
