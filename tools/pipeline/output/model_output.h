// SPDX-License-Identifier: GPL-3.0-or-later
// Writes a model with the record of how it was built: a folder, or one .glb.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "atlas/model/model_file.h"
#include "atlas/model/piecewise_model.h"
#include "tools/base/output_folder.h"
#include "tools/scene/scene.h"

namespace lumatlas {

// Returns the folder for scratch files while `output` is made: the one that the environment variable TMPDIR names, if
// it is there, else the one that takes the output, because that has room for photographs.
[[nodiscard]] std::filesystem::path scratch_folder_for(const std::filesystem::path& output);

// The notes of `build` on how it made a model: lumatlas.json and plan.json in a folder, "extras" of the asset in a
// .glb.
struct ModelNotes {
  nlohmann::json options;  // in effect; null: not known
  nlohmann::json plan;     // see plan_json(); null: not known
};

// Reads the notes in a model's folder, its .gltf file, or a .glb. Throws InputError if there is no such model. Notes
// that are missing, or that another program wrote, are null.
[[nodiscard]] ModelNotes read_model_notes(const std::filesystem::path& model);

// Returns the views that a model was built without; none: it was built from all. Throws InputError, naming `model`, if
// its notes do not say.
[[nodiscard]] std::optional<HoldOut> hold_out_of(const ModelNotes& notes, const std::filesystem::path& model);

// Returns whether the model was built without photographs that were bad: PictureFolders::skip_bad.
[[nodiscard]] bool skips_bad(const ModelNotes& notes);

// Returns the name of the unit of a model's lengths, "m" where its position on the Earth is known; empty: not known.
// Throws InputError as read_model_json().
[[nodiscard]] std::string length_unit_of(const std::filesystem::path& model);

// Complete or not at all, as OutputFolder and AtomicFile.
class ModelOutput {
 public:
  // A path that ends in .glb is one file, anything else a folder. Refuses at once what commit() would refuse.
  explicit ModelOutput(const std::filesystem::path& path);

  [[nodiscard]] const std::filesystem::path& target() const { return target_; }
  [[nodiscard]] bool is_one_file() const { return file_ != nullptr; }

  // `texture` may be null. Throws InputError, Interrupted.
  void commit(const Snapshot& snapshot, const ValidityOptions& validity, const ImageCoding& photographs,
              const ModelNotes& notes, const BaseTexture* texture);
  // Commits a model whose surface comes in pieces; not to one file (std::logic_error), which is made from the whole.
  void commit(const PiecewiseModel& model, const ValidityOptions& validity, const ImageCoding& photographs,
              const ModelNotes& notes);

 private:
  void commit_folder(const ModelNotes& notes);

  std::filesystem::path target_;          // the given path
  std::unique_ptr<OutputFolder> folder_;  // one of the two
  std::unique_ptr<AtomicFile> file_;
};

}  // namespace lumatlas
