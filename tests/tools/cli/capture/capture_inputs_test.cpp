// SPDX-License-Identifier: GPL-3.0-or-later
// What `lumatlas capture` is given besides a folder of a few JPEG files: photographs in other forms, videos, many
// photographs, poses, and how COLMAP is to work.
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sqlite3.h>
#include <sys/prctl.h>
#include <sys/syscall.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <exception>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "atlas/images/photograph.h"
#include "mesh/base/errors.h"
#include "mesh/base/whole_file.h"
#include "tests/support/skip.h"
#include "tests/tools/cli/capture/capture_surroundings.h"
#include "tools/base/process/child_process.h"
#include "tools/capture/sources/capture_sources.h"
#include "tools/capture/sources/prepared_photographs.h"
#include "tools/scene/forms/colmap/colmap.h"
#include "tools/scene/forms/colmap/colmap_writer.h"
#include "tools/scene/scene.h"

namespace lumatlas {
namespace {

using namespace capturing;

// Makes the stand-in leave a model of the shared scene whose photographs are called otherwise.
template <typename Rename>
void leave_model_of(const Surroundings& room, const Rename& renamed) {
  std::vector<WrittenView> written;
  for (const SceneView& view : read_scene_views(made().scene, glm::dvec3(0)).views) {
    written.push_back({renamed(view.name, written.size()), view.camera});
  }
  fs::remove_all(room.bin() / "models");
  fs::create_directories(room.bin() / "models" / "0");
  const std::vector<ColmapPoint> points = read_colmap_points(read_colmap_model(made().scene));
  std::vector<TrackedPoint> tracked;
  for (const ColmapPoint& point : points) {
    TrackedPoint seen{point.position, point.color, {}};
    for (const std::uint32_t image : point.images) seen.track.push_back({image - 1, {1, 1}});
    tracked.push_back(std::move(seen));
  }
  write_colmap_model(room.bin() / "models" / "0", written, tracked);
}

Arguments with(const Surroundings& room, const Arguments& more) {
  Arguments arguments = room.arguments();
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

Arguments with_quiet(Arguments arguments) {
  arguments.push_back("--quiet");
  return arguments;
}

void write_jpeg(const fs::path& file, const Photograph& photograph, const CameraNote& note) {
  const std::vector<std::uint8_t> bytes = encode_image(photograph, {ImageFormat::jpeg, 90}, note);
  write_whole_file(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// Puts a HEIC file NAME.HEIC in the place of a photograph. Returns false, and skips the test, where none can be
// written.
bool becomes_heic(const fs::path& photograph) {
  const fs::path written = fs::path(photograph).replace_extension(".heic");
  try {
    write_image(written, read_photograph(photograph));
  } catch (const InputError& error) {
    skip(std::string("OpenImageIO does not write HEIC: ") + error.what());
    return false;
  }
  fs::rename(written, fs::path(photograph).replace_extension(".HEIC"));
  fs::remove(photograph);
  return true;
}

// Makes all photographs HEIC files, and the stand-in leave a model of the JPEG files that are made of them.
bool become_heic(const Surroundings& room) {
  for (const std::string& name : room.names()) {
    if (!becomes_heic(room.photographs() / name)) return false;
  }
  leave_model_of(room, [](const std::string& name, std::size_t) {
    return fs::path(name).replace_extension(".HEIC").string() + ".jpg";
  });
  return true;
}

TEST_CASE("HEIC photographs become JPEG files that COLMAP reads, and what shows the same is left out") {
  const Surroundings room;
  if (!become_heic(room)) return;
  const std::string first = names_in(room.photographs()).front();
  const std::string stem = fs::path(first).stem().string();
  // A raw file beside a JPEG, a moving photograph, a picture in another form, and a file that is damaged.
  write_image(room.photographs() / "again.jpg", read_photograph(room.photographs() / first));
  std::ofstream(room.photographs() / "again.DNG") << "raw";
  std::ofstream(room.photographs() / (stem + ".mov")) << "moving";
  std::ofstream(room.photographs() / "old.bmp") << "BM";
  std::ofstream(room.photographs() / "new.jxl") << "JXL";
  std::ofstream(room.photographs() / "converted.heic") << "HEIC";
  fs::copy(room.photographs() / "again.jpg", room.photographs() / "converted.heic.jpg");
  std::ofstream(room.photographs() / "broken.heic") << "no picture";
  const Outcome outcome = lumatlas_here(room.arguments());
  const json result = printed(outcome);
  CHECK(result["photographs"]["count"] == 14);
  CHECK(result["photographs"]["converted"] == 12);
  CHECK(result["photographs"]["missed"] == json{"again.jpg", "converted.heic.jpg"});
  CHECK_THAT(result["left_out"]["again.DNG"].get<std::string>(), Catch::Contains("the same as again.jpg beside it"));
  CHECK_THAT(result["left_out"][stem + ".mov"].get<std::string>(), Catch::Contains("moving part of the photograph"));
  CHECK_THAT(result["left_out"]["old.bmp"].get<std::string>(),
             Catch::Contains("is a BMP picture, which capture does not"));
  CHECK_THAT(result["left_out"]["new.jxl"].get<std::string>(),
             Catch::Contains("is a JPEG XL picture, which capture does not read: save it as JPEG or PNG"));
  CHECK_THAT(result["left_out"]["converted.heic"].get<std::string>(),
             Catch::Contains("the same as converted.heic.jpg beside it"));
  CHECK_THAT(result["left_out"]["broken.heic"].get<std::string>(), Catch::Contains("cannot be used: "));
  CHECK(result["left_out"].size() == 6);
  CHECK_THAT(outcome.err, Catch::Contains("step 1 of 6, photographs") && Catch::Contains("step 6 of 6, build") &&
                              Catch::Contains("left out: old.bmp"));
  CHECK(fs::is_symlink(room.work() / "images" / "again.jpg"));
  CHECK(fs::is_regular_file(fs::symlink_status(room.work() / "images" / (first + ".jpg"))));
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "photographs features matching mapping mesh build ");
  // A photograph that has gone is not left in the folder that COLMAP reads.
  fs::remove(room.photographs() / "again.jpg");
  fs::remove(room.photographs() / "again.DNG");
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "photographs ");
  CHECK_FALSE(fs::exists(fs::symlink_status(room.work() / "images" / "again.jpg")));
}

TEST_CASE("a folder that gets its first HEIC photograph keeps the features of the others") {
  const Surroundings room;
  (void)printed(lumatlas_here(room.arguments()));
  (void)room.calls();
  fs::remove(room.bin() / "kept");
  fs::create_directory(room.photographs() / "phone");
  fs::copy(room.photographs() / room.names().front(), room.photographs() / "phone" / "IMG 1.png");
  if (!becomes_heic(room.photographs() / "phone" / "IMG 1.png")) return;
  const json result = printed(lumatlas_here(room.arguments()));
  CHECK(result["photographs"]["count"] == 13);
  CHECK(result["photographs"]["missed"] == json{"phone/IMG 1.HEIC.jpg"});
  CHECK(room.calls() == kAllCalls);
  CHECK(fs::remove(room.bin() / "kept"));  // the database
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "photographs features matching mapping mesh build ");
  // The same photographs in another folder may be other ones.
  fs::rename(room.photographs(), room.folder() / "moved");
  Arguments moved = room.arguments();
  moved[1] = (room.folder() / "moved").string();
  (void)printed(lumatlas_here(moved));
  CHECK_FALSE(fs::exists(room.bin() / "kept"));
}

TEST_CASE("a capture of an earlier version, whose images are a link to the photographs, goes on") {
  const Surroundings room;
  (void)printed(lumatlas_here(room.arguments()));
  (void)room.calls();
  fs::remove_all(room.work() / "images");
  fs::create_directory_symlink(room.photographs(), room.work() / "images");
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "features matching mapping mesh build ");
  CHECK(room.calls().empty());
  CHECK(fs::is_directory(fs::symlink_status(room.work() / "images")));
  CHECK(room.names().size() == 12);
}

TEST_CASE("a capture of an earlier version, with a folder of photographs that were made, goes on") {
  const Surroundings room;
  if (!become_heic(room)) return;
  (void)printed(lumatlas_here(room.arguments()));
  (void)room.calls();
  fs::remove(room.bin() / "kept");
  fs::rename(room.work() / "images", room.work() / "photographs");
  fs::create_directory_symlink(room.work() / "photographs", room.work() / "images");
  const fs::path record = room.work() / "capture.json";
  json steps = json::parse(bytes_of(record));
  steps["steps"]["features"]["inputs"]["folder"] = (room.work() / "photographs").string();
  std::ofstream(record) << steps;
  const json result = printed(lumatlas_here(room.arguments()));
  CHECK(done_before(result) == "photographs ");  // no photograph was made anew
  CHECK(fs::exists(room.bin() / "kept"));
  CHECK(fs::is_directory(fs::symlink_status(room.work() / "images")));
  CHECK_FALSE(fs::exists(room.work() / "photographs"));
}

TEST_CASE("photographs in a linked folder are captured, and a circle of links ends") {
  const Surroundings room;
  const fs::path card = room.folder() / "card";
  fs::rename(room.photographs(), card);
  fs::create_directory(room.photographs());
  fs::create_directory_symlink(card, room.photographs() / "card1");
  fs::create_directory_symlink(room.photographs(), room.photographs() / "circle");
  leave_model_of(room, [](const std::string& name, std::size_t) { return "card1/" + name; });
  const json result = printed(lumatlas_here(room.arguments()));
  CHECK(result["photographs"]["count"] == 12);
  CHECK(result["photographs"]["missed"].empty());
}

// Lets this thread, and what it starts, make no symbolic links from now on, as on a FAT file system. Returns false
// where the system does not allow that.
bool forbid_links() {
  std::array filter{sock_filter{BPF_LD | BPF_W | BPF_ABS, 0, 0, offsetof(seccomp_data, nr)},
                    sock_filter{BPF_JMP | BPF_JEQ | BPF_K, 1, 0, SYS_symlinkat},
#ifdef SYS_symlink
                    sock_filter{BPF_JMP | BPF_JEQ | BPF_K, 0, 1, SYS_symlink},
#else
                    sock_filter{BPF_JMP | BPF_JA, 0, 0, 1},
#endif
                    sock_filter{BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ERRNO | EPERM},
                    sock_filter{BPF_RET | BPF_K, 0, 0, SECCOMP_RET_ALLOW}};
  const sock_fprog program{static_cast<unsigned short>(filter.size()), filter.data()};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

TEST_CASE("files without a byte are left out unread, also where the kernel never ends reading them") {
  const Surroundings room;
  const fs::path folder = room.photographs();
  write_whole_file(folder / "cut.mp4", "");
  for (const char* const name : {"log.png", "log.heic", "log.webm"}) fs::create_symlink("/proc/kmsg", folder / name);
  const CaptureSources sources = find_sources(folder, {});
  CHECK(sources.videos.empty());
  CHECK(sources.converted.empty());
  for (const char* const name : {"cut.mp4", "log.png", "log.heic", "log.webm"}) {
    CAPTURE(name);
    REQUIRE(sources.left_out.contains(name));
    CHECK(sources.left_out.at(name) == "is empty");
  }
  CHECK_THROWS_WITH(find_sources(folder / "cut.mp4", {}), Catch::EndsWith("cut.mp4: is empty"));
  CHECK_THROWS_WITH(photograph_size(folder / "log.png"), Catch::EndsWith("log.png: is empty"));
}

TEST_CASE("on a file system without links COLMAP reads copies, which are kept") {
  const Surroundings room;
  const CaptureSources sources = find_sources(room.photographs(), {});
  const fs::path images = room.work() / "images", first = room.photographs() / room.names().front();
  bool forbidden = false;
  std::vector<fs::file_time_type> times;
  std::string failure;
  std::thread([&] {
    forbidden = forbid_links();
    if (!forbidden) return;
    try {
      for (int run = 0; run < 3; ++run) {
        if (run == 2) fs::last_write_time(first, fs::last_write_time(first) + std::chrono::seconds(1));
        (void)prepare_photographs(sources, room.work(), 300, {});
        times.push_back(fs::last_write_time(images / first.filename()));
      }
    } catch (const std::exception& error) {
      failure = error.what();
    }
  }).join();
  if (!forbidden) return skip("the system allows no filter of system calls");
  CHECK(failure.empty());
  REQUIRE(times.size() == 3);
  CHECK(times[0] == times[1]);
  CHECK(times[2] == fs::last_write_time(first));
  for (const std::string& name : room.names()) {
    CHECK(fs::is_regular_file(fs::symlink_status(images / name)));
    CHECK(bytes_of(images / name) == bytes_of(room.photographs() / name));
  }
}

// A video of the photographs, each of them `times` times.
std::optional<fs::path> video_of(const Surroundings& room, const fs::path& file, std::size_t times) {
  if (find_program("ffmpeg").empty()) {
    skip("FFmpeg is not installed");
    return std::nullopt;
  }
  const fs::path frames = room.folder() / "frames";
  fs::remove_all(frames);
  fs::create_directory(frames);
  std::size_t count = 0;
  for (const std::string& name : room.names()) {
    for (std::size_t i = 0; i < times; ++i, ++count) {
      fs::copy(room.photographs() / name, frames / (std::to_string(10000 + count) + ".png"));
    }
  }
  REQUIRE(run_to_end({find_program("ffmpeg"),
                      {"-y", "-start_number", "10000", "-i", (frames / "%d.png").string(), "-c:v", "libx264", "-crf",
                       "4", file.string()},
                      room.folder() / "out.txt",
                      room.folder() / "err.txt"}) == 0);
  return file;
}

TEST_CASE("frames of a video become photographs, and outputs may lie beside it") {
  const Surroundings room;
  const std::optional<fs::path> video = video_of(room, room.folder() / "walk.mp4", 3);
  if (!video) return;
  // The views of the scene are far apart: each is a take of its own, whose first frame is as sharp as its others.
  leave_model_of(room, [](const std::string&, std::size_t i) {
    const std::string number = std::to_string(3 * i);
    return "walk.mp4/" + std::string(6 - number.size(), '0') + number + ".jpg";
  });
  Arguments arguments = room.arguments();
  arguments[1] = video->string();
  const Outcome outcome = lumatlas_here(arguments);
  const json result = printed(outcome);
  REQUIRE(result["videos"].size() == 1);
  CHECK(result["videos"][0]["name"] == "walk.mp4");
  CHECK(result["videos"][0]["frames"] == 36);
  const std::size_t taken = result["videos"][0]["taken"];
  CHECK(taken >= 12);
  CHECK(result["videos"][0]["damage"].is_null());
  CHECK(result["photographs"]["count"] == taken);
  CHECK_THAT(outcome.err,
             Catch::Contains("of 36 frames are taken, the sharpest wherever the picture has moved by about 10 %"));
  CHECK(names_in(room.work() / "images" / "walk.mp4").size() == taken);
  CHECK(done_before(printed(lumatlas_here(arguments))) == "photographs features matching mapping mesh build ");
  // Fewer frames: those that stay are not made again.
  const fs::path frames = room.work() / "images" / "walk.mp4";
  std::map<std::string, fs::file_time_type> times;
  for (const std::string& name : names_in(frames)) times[name] = fs::last_write_time(frames / name);
  arguments.insert(arguments.end(), {"--max-frames", "2"});
  const Outcome fewer = lumatlas_here(arguments);
  CHECK_THAT(fewer.err, Catch::Contains("would take more than 2 frames (--max-frames)"));
  CHECK(names_in(frames).size() == 2);
  for (const std::string& name : names_in(frames)) CHECK(times[name] == fs::last_write_time(frames / name));
}

TEST_CASE("a folder of videos and photographs gives photographs of both, each video with a lens of its own") {
  const Surroundings room;
  const std::optional<fs::path> video = video_of(room, room.photographs() / "walk.mp4", 1);
  if (!video) return;
  fs::copy(*video, room.photographs() / "again.MOV");
  fs::create_directory(room.photographs() / "more");
  fs::copy(*video, room.photographs() / "more" / "walk.mp4");
  const Outcome outcome = lumatlas_here(room.arguments());
  const json result = printed(outcome);
  REQUIRE(result["videos"].size() == 3);
  CHECK(result["videos"][1]["name"] == "more/walk.mp4");
  CHECK_THAT(outcome.err, Catch::Contains("taken as of 4 lenses"));
  CHECK(fs::is_directory(room.work() / "images" / "more" / "walk.mp4"));
}

TEST_CASE("what is said to be a video and is none is refused by name") {
  if (find_program("ffmpeg").empty()) return skip("FFmpeg is not installed");
  const Surroundings room;
  std::ofstream(room.photographs() / "walk.mp4") << "no video";
  check_failure(lumatlas_here(with(room, {"--quiet"})), "walk.mp4: cannot be read as a video, FFmpeg says '");
  CHECK(room.calls().empty());
}

// Photographs of one pixel's colour, `count` of them, each with the note; none is decoded.
void add_photographs(const Surroundings& room, std::size_t count, const std::optional<GpsPosition>& place) {
  const Photograph grey{64, 48, std::vector<std::uint8_t>(std::size_t{64} * 48 * 3, 99), {}};
  for (std::size_t i = 0; i < count; ++i) {
    write_jpeg(room.photographs() / ("more " + std::to_string(i) + ".jpg"), grey, {{64, 48}, "", "", 0, 0, place});
  }
}

TEST_CASE("many photographs are compared with their neighbours by name and GPS, and some of all with each other") {
  const Surroundings room;
  add_photographs(room, 195, GpsPosition{52.5, 13.4, 30});
  const Outcome outcome = lumatlas_here(room.arguments());
  (void)printed(outcome);
  CHECK(room.calls() == "feature_extractor sequential_matcher spatial_matcher matches_importer mapper ");
  // Names with blanks cannot stand in COLMAP's list.
  const std::string links = bytes_of(room.bin() / "links");
  CHECK(std::count(links.begin(), links.end(), '\n') == 12 * 11 / 2);
  CHECK_THAT(links, !Catch::Contains("more"));
  CHECK_THAT(outcome.err,
             Catch::Contains("with its neighbours by name and by GPS, and 12 photographs with each other"));

  const auto done_anew = [&](const Arguments& more) {
    fs::remove_all(room.model());  // which a capture that misses most photographs does not replace
    (void)printed(lumatlas_here(with(room, more)));
    return room.calls();
  };
  const fs::path tree = room.folder() / "tree.bin";
  std::ofstream(tree) << "tree";
  CHECK(done_anew({"--vocabulary", tree.string()}) == "sequential_matcher spatial_matcher vocab_tree_matcher mapper ");
  check_failure(lumatlas_here(with(room, {"--vocabulary", (room.folder() / "none").string(), "--quiet"})),
                "--vocabulary is a vocabulary tree of COLMAP");
  CHECK(done_anew({"--matching", "spatial"}) == "spatial_matcher mapper ");
}

TEST_CASE("without GPS, matching by it is refused") {
  const Surroundings room;
  check_failure(lumatlas_here(with(room, {"--matching", "spatial", "--quiet"})),
                "GPS tells the place of 0 % of the photographs, --matching spatial needs half");
}

TEST_CASE("lens model and mapper are COLMAP's to know") {
  const Surroundings room;
  (void)printed(lumatlas_here(with(room, {"--camera-model", "OPENCV_FISHEYE"})));
  CHECK_THAT(bytes_of(room.bin() / "calls"), Catch::Contains("--ImageReader.camera_model OPENCV_FISHEYE"));
  const Outcome unknown = lumatlas_here(with(room, {"--camera-model", "BROWN"}));
  CHECK(unknown.status == 2);
  CHECK_THAT(unknown.err, Catch::Contains("camera_model is 'BROWN', must be one of COLMAP's models"));
  check_failure(lumatlas_here(with(room, {"--mapper", "global", "--quiet"})),
                "the colmap in PATH has no global mapper (it comes with COLMAP 4), and there is no glomap");
  (void)room.note("global");
  (void)room.calls();
  const json result = printed(lumatlas_here(with(room, {"--mapper", "global"})));
  CHECK_THAT(room.calls(), Catch::Contains("global_mapper"));
  CHECK(result["reconstructions"] == json{12});
}

// Makes the stand-in leave a database with these photographs, whose ids count down to 1.
void leave_database_of(const Surroundings& room, const std::vector<std::string>& names) {
  sqlite3* database = nullptr;
  REQUIRE(sqlite3_open((room.bin() / "database").c_str(), &database) == SQLITE_OK);
  std::string statements = "CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER);";
  for (std::size_t i = 0; i < names.size(); ++i) {
    statements += "INSERT INTO images VALUES (" + std::to_string(names.size() - i) + ", '" + names[i] + "', 1);";
  }
  CHECK(sqlite3_exec(database, statements.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
  REQUIRE(sqlite3_close(database) == SQLITE_OK);
}

TEST_CASE("where poses are known COLMAP finds points alone, and the poses stay as they are") {
  const Surroundings room;
  const Arguments posed{
      "capture", room.photographs().string(), "-o", room.model().string(), "--hold", "4", "--poses", made().scene,
      "--json"};
  check_failure(lumatlas_here(with_quiet(posed)), "database.db: cannot be read as COLMAP's database (no such table");
  fs::remove_all(room.work());
  (void)room.calls();
  leave_database_of(room, room.names());
  const Outcome outcome = lumatlas_here(posed);
  (void)printed(outcome);
  CHECK(room.calls() == "feature_extractor exhaustive_matcher point_triangulator ");
  const std::vector<ColmapImage> images = read_colmap_model(room.work()).images;
  for (std::size_t i = 0; i < images.size(); ++i) CHECK(images[i].id == images.size() - i);
  CHECK_THAT(outcome.err, Catch::Contains("is read as COLMAP: it has poses of 12 of the 12 photographs"));
  const SceneViews before = read_scene_views(made().scene, glm::dvec3(0)),
                   now = read_scene_views(room.work(), glm::dvec3(0));
  REQUIRE(now.views.size() == before.views.size());
  for (std::size_t i = 0; i < now.views.size(); ++i) {
    CHECK(now.views[i].name == before.views[i].name);
    CHECK(now.views[i].lens == before.views[i].lens);
    CHECK(glm::distance(now.views[i].camera.center(), before.views[i].camera.center()) < 1e-9);
  }
  CHECK(done_before(printed(lumatlas_here(posed))) == "features matching mapping mesh build ");
  CHECK(done_before(printed(lumatlas_here(room.arguments()))) == "features matching ");

  // A photograph without a pose is told; names that fit none are told with both.
  fs::copy(room.photographs() / room.names().front(), room.photographs() / "unposed.png");
  CHECK(printed(lumatlas_here(posed))["photographs"]["missed"] == json{"unposed.png"});
  const TemporaryFolder others;
  for (const char* const name : {"x.png", "y.png"}) {
    write_image(others / name, {64, 48, std::vector<std::uint8_t>(std::size_t{64} * 48 * 3, 50), {}});
  }
  check_failure(lumatlas_here({"capture", others.path().string(), "-o", (room.folder() / "other").string(), "--poses",
                               made().scene, "--quiet"}),
                made().scene + ": read as COLMAP, it has poses of 0 of the 2 photographs in ");
}

TEST_CASE("poses of HEIC photographs are found by their own names and by those of their JPEG files") {
  const Surroundings room;
  const std::vector<std::string> names = room.names();
  if (!become_heic(room)) return;
  std::vector<std::string> made_names;
  for (const std::string& name : names)
    made_names.push_back(fs::path(name).replace_extension(".HEIC").string() + ".jpg");
  leave_database_of(room, made_names);
  // The first three by their own names, three by those of JPEG files that another program made, the others as COLMAP's.
  const auto posed_name = [](const std::string& name, std::size_t i) {
    if (i < 3) return fs::path(name).replace_extension(".HEIC").string();
    if (i < 6) return fs::path(name).replace_extension(".JPG").string();
    return fs::path(name).replace_extension(".HEIC").string() + ".jpg";
  };
  leave_model_of(room, posed_name);
  const fs::path scene = room.folder() / "posed";
  fs::create_directories(scene / "sparse");
  fs::copy(room.bin() / "models" / "0", scene / "sparse" / "0", fs::copy_options::recursive);
  const Outcome outcome = lumatlas_here({"capture", room.photographs().string(), "-o", room.model().string(), "--hold",
                                         "4", "--poses", scene.string(), "--json"});
  CHECK(printed(outcome)["photographs"]["missed"].empty());
  CHECK_THAT(outcome.err, Catch::Contains("is read as COLMAP: it has poses of 12 of the 12 photographs"));
  std::vector<std::string> placed;
  for (const ColmapImage& image : read_colmap_model(room.work()).images) placed.push_back(image.name);
  std::sort(placed.begin(), placed.end());
  CHECK(placed == made_names);
}

}  // namespace
}  // namespace lumatlas
