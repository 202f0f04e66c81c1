// SPDX-License-Identifier: GPL-3.0-or-later
// Outputs that appear complete or not at all: they grow beside their place, on the same file system, and are moved into
// it by commit(). Without commit() nothing remains of them, and what was there before stays as it was. What a process
// that was killed at once left behind (.lumatlas-*) is removed by the next output at its side.
//
// A path through a symbolic link stands for what the link points to. Everything here throws InputError when the file
// system refuses something: one sentence with the path and the reason.
#pragma once

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "mesh/base/pending_file.h"
#include "mesh/base/temporary_entry.h"

namespace lumatlas {

// A folder's file that says which command of lumatlas wrote it, with which options and which files, so that it may be
// replaced.
inline constexpr const char* kMarkerFile = "lumatlas.json";

// A folder may be replaced by an output of `command` if it is empty, or if an earlier output of the same command is all
// that is in it: a person's own files are never removed. A report of `lumatlas validate` inside it goes with it. Throws
// InputError for any other existing path, naming the first file that stands in the way.
void check_replaceable(const std::filesystem::path& folder, const std::string& command);

// Throws InputError if an output at `output` would take the place of one of the inputs, because it is that or a folder
// around it. Empty paths among the inputs, for what was not given, are left out.
void check_apart(const std::filesystem::path& output, std::span<const std::filesystem::path> inputs);

class OutputFolder {
 public:
  // `command` of lumatlas makes it. Missing parents are made, and removed again if nothing is committed. Puts back an
  // earlier output that a killed process left under swap_name(). Refuses at once what commit() would refuse.
  OutputFolder(const std::filesystem::path& path, std::string command);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  // Returns the folder to write to before commit(), and the folder of the output afterwards.
  [[nodiscard]] const std::filesystem::path& path() const { return committed_ ? target_ : temporary_->path(); }

  // Writes the marker file {"lumatlas": version, "command": ..., "files": [...], "options": effective_options}, waits
  // until the disk has it all, and moves the folder into its place. An earlier output is exchanged with it in one step
  // and removed; see below for file systems that cannot exchange. Throws std::invalid_argument if called twice,
  // Interrupted if the user has asked the program to stop.
  void commit(const nlohmann::json& effective_options);

 private:
  void put_in_place();

  std::filesystem::path target_;
  std::string command_;
  std::unique_ptr<TemporaryEntry> temporary_;
  std::vector<std::filesystem::path> made_parents_;  // outermost first
  bool committed_ = false;
};

// A PendingFile to stream into. An existing regular file is replaced, anything else that exists is refused.
class AtomicFile {
 public:
  explicit AtomicFile(const std::filesystem::path& path);

  [[nodiscard]] std::ofstream& stream() { return stream_; }  // binary; commit() checks for failed writes
  void commit();                                             // throws std::invalid_argument if called twice

 private:
  std::filesystem::path target_;
  PendingFile pending_;
  std::ofstream stream_;
  bool committed_ = false;
};

// The text of a JSON file or result. Names of files may hold bytes that are not UTF-8: they become U+FFFD, rather than
// cost the whole output.
[[nodiscard]] std::string json_text(const nlohmann::json& value);
void write_json(const std::filesystem::path& path, const nlohmann::json& value);  // writes an AtomicFile

// The two ways in which commit() puts `fresh` in the place of the existing folder `target`; `fresh` then holds what
// `target` held. Exchanging is one step, but some file systems (NFS, exFAT) cannot: then it returns false and nothing
// has changed. Renaming leaves no folder at `target` for a moment, in which the old one is at swap_name(target), and
// puts the old one back if it fails.
[[nodiscard]] bool exchange_folders(const std::filesystem::path& fresh, const std::filesystem::path& target);
void swap_folders_by_renaming(const std::filesystem::path& fresh, const std::filesystem::path& target);

// A new path beside `target`, ".lumatlas-DIGITS-earlier-NAME", which remove_leftovers() does not remove. If a process
// was killed in the moment of a swap, the next OutputFolder for `target` finds the old folder under this name. It moves
// the folder back if nothing or an empty folder is at `target`, and removes it if the new output is there. A folder on
// NFS cannot be locked, so it is left to the user. Where NAME has more than 204 bytes, the path is a temporary one.
[[nodiscard]] std::filesystem::path swap_name(const std::filesystem::path& target);

}  // namespace lumatlas
