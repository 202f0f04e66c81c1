// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/site.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <ostream>
#include <span>
#include <stdexcept>
#include <utility>

#include "atlas/model/content_digest.h"
#include "atlas/model/model_form.h"
#include "blend/blend_options.h"
#include "blend/gl/shader_program.h"
#include "blend/shaders.h"
#include "blend/tables/fade_zone_shares.h"
#include "mesh/base/errors.h"
#include "tools/base/html_text.h"
#include "tools/base/process/process_limits.h"
#include "tools/picture/paths/kept_path.h"
#include "tools/viewer/base64.h"
#include "tools/viewer/page_assets.h"
#include "tools/viewer/page_file.h"

namespace lumatlas {

namespace {

using nlohmann::json;

std::vector<std::uint8_t> bytes_of_text(std::string_view text) {
  return {text.begin(), text.end()};
}

json json_of(const BlendOptions& options) {
  return {{"views", options.views},
          {"lambda", options.lambda},
          {"printed_position", options.position == BlendOptions::Position::printed},
          {"rims", options.rims},
          {"fade_last", options.fade_last},
          {"consistent", options.consistent},
          {"frame_fade", options.frame_fade},
          {"cubic", options.sampling == BlendOptions::Sampling::cubic},
          {"soften", options.soften},
          {"soft_edges", options.soft_edges},
          {"outlines", options.outlines},
          {"prefilter", options.prefilter},
          {"nearby_exposure", options.exposure == BlendOptions::Exposure::nearby},
          {"supersample", options.supersample},
          {"antialias_all", options.antialias == BlendOptions::Antialias::all},
          {"occlusion_tolerance", options.occlusion_tolerance}};
}

// The shaders and how the page blends are the same for every version of every model, so that a browser fetches them
// once.
SiteFile shaders_file() {
  const json sources = {{"surface.vert", k_surface_vert},
                        {"surface.frag", k_surface_frag},
                        {"screen.vert", k_screen_vert},
                        {"blend.frag", k_blend_frag},
                        {"silhouettes.frag", k_silhouettes_frag},
                        {"outline_rows.frag", k_outline_rows_frag},
                        {"outlines.frag", k_outlines_frag},
                        {"edges.frag", k_edges_frag},
                        {"edge_rows.frag", k_edge_rows_frag},
                        {"soft_edges.frag", k_soft_edges_frag},
                        {"diagnose.frag", k_diagnose_frag},
                        {"depth.frag", k_depth_frag},
                        {"photograph.frag", k_photograph_frag},
                        {"bc7.frag", k_bc7_frag},
                        {"etc2.frag", k_etc2_frag},
                        {"page.frag", k_page_frag},
                        {"modes.frag", k_modes_frag},
                        {"fade.frag", k_fade_frag},
                        {"glance.frag", k_glance_frag},
                        {"needs.frag", k_needs_frag},
                        {"surroundings.frag", k_surroundings_frag}};
  const json photographed = {
      {"cosine", kPhotographedCosine}, {"enlargement", kPhotographedEnlargement}, {"share", kCoveredShare}};
  const json value = {{"lumatlas", LUMATLAS_VERSION},
                      {"definitions", shared_definitions()},
                      {"sources", sources},
                      {"blend", json_of(BlendOptions{})},
                      {"photographed", photographed}};
  return {"shaders.json", "application/json", bytes_of_text(value.dump())};
}

// The file under a name that says what it holds, so that no cache takes one version of a file for another.
SiteFile named_by_content(SiteFile file) {
  const std::size_t dot = file.name.rfind('.');
  file.name = name_by_content(file.name.substr(0, dot), file.name.substr(dot), file.bytes);
  return file;
}

std::size_t views_of(const Snapshot& snapshot) {
  return static_cast<std::size_t>(
      std::count_if(snapshot.views.begin(), snapshot.views.end(), [](const auto& view) { return view != nullptr; }));
}

// The scale of photographs of which none is longer than that.
double site_scale(const Snapshot& snapshot, std::uint32_t most_side_px) {
  std::uint32_t longest = 1;
  for (const auto& view : snapshot.views) {
    if (view) longest = std::max({longest, view->camera.width, view->camera.height});
  }
  return std::min(1.0, static_cast<double>(most_side_px) / longest);
}

// The pixel of a picture that a pixel of the smaller one shows.
std::size_t nearest(std::uint32_t pixel, double factor, std::uint32_t size) {
  return std::min(static_cast<std::size_t>((pixel + 0.5) / factor), std::size_t{size} - 1);
}

// The view with fewer pixels. Those of the last column and row may be wider than the picture.
StoredView smaller_view(const StoredView& view, double factor) {
  ScaledView scaled = scaled_view(view, factor);
  StoredView result;
  result.name = view.name;
  result.camera = view.camera;
  result.camera.width = scaled.width;
  result.camera.height = scaled.height;
  for (double* length : {&result.camera.fx, &result.camera.fy, &result.camera.cx, &result.camera.cy}) *length *= factor;
  result.photograph = std::make_shared<const StoredPhotograph>(std::move(scaled.photograph));
  ViewMask mask;
  mask.validity = std::move(scaled.validity);
  mask.rim = std::move(scaled.rim);
  std::vector<float> depth;
  depth.reserve(mask.validity.size());
  for (std::uint32_t y = 0; y < scaled.height; ++y) {
    for (std::uint32_t x = 0; x < scaled.width; ++x) {
      const std::size_t row = nearest(y, factor, view.camera.height);
      depth.push_back(view.mask->depth[row * view.camera.width + nearest(x, factor, view.camera.width)]);
    }
  }
  mask.depth = std::move(depth);
  result.mask = std::make_shared<const ViewMask>(std::move(mask));
  return result;
}

// Cuts smaller views into tiles of the same size: a tile is there if it shows a part of one that was. What of it was
// not there becomes invalid.
class SmallerTiles {
 public:
  SmallerTiles(const TileTable& before, double factor) : before_(before), factor_(factor) {
    after_.options = before.options;
  }

  // Takes the next view slot. Null: it is free.
  void take(const StoredView* view, StoredView* smaller) {
    after_.first_tile.push_back(static_cast<std::uint32_t>(after_.places.size()));
    const auto slot = static_cast<std::uint32_t>(after_.first_tile.size()) - 1;
    if (!view) return;
    const std::uint32_t tile_px = before_.options.tile_px;
    const TileGrid old(view->camera.width, view->camera.height, tile_px);
    const TileGrid grid(smaller->camera.width, smaller->camera.height, tile_px);
    std::vector<std::uint8_t> there(grid.tiles(), 0);
    auto mask = std::make_shared<ViewMask>(*smaller->mask);
    std::vector<std::uint8_t>& validity = mask->validity.values();
    for (std::size_t pixel = 0; pixel < validity.size(); ++pixel) {
      const auto x = static_cast<std::uint32_t>(pixel % smaller->camera.width);
      const auto y = static_cast<std::uint32_t>(pixel / smaller->camera.width);
      const std::size_t column = nearest(x, factor_, view->camera.width) / tile_px;
      const std::size_t row = nearest(y, factor_, view->camera.height) / tile_px;
      const bool was_there = before_.places[before_.first_tile[slot] + row * old.columns + column] != TilePlace::none;
      if (was_there) {
        there[std::size_t{y / tile_px} * grid.columns + x / tile_px] = 1;
      } else {
        validity[pixel] = 0;
      }
    }
    smaller->mask = std::move(mask);
    for (const std::uint8_t is_there : there) after_.places.push_back(is_there ? TilePlace{next_++} : TilePlace::none);
  }

  TileTable table() {
    after_.first_tile.push_back(static_cast<std::uint32_t>(after_.places.size()));
    return std::move(after_);
  }

 private:
  const TileTable& before_;
  double factor_;
  TileTable after_;
  std::uint32_t next_ = 0;
};

Snapshot smaller_snapshot(const Snapshot& snapshot, double factor) {
  Snapshot smaller = snapshot;
  SmallerTiles tiles(snapshot.tiles, factor);
  for (auto& view : smaller.views) {
    const std::shared_ptr<const StoredView> given = view;
    auto scaled = given ? std::make_shared<StoredView>(smaller_view(*given, factor)) : nullptr;
    if (!snapshot.tiles.whole_views()) tiles.take(given.get(), scaled.get());
    view = std::move(scaled);
  }
  if (!snapshot.tiles.whole_views()) smaller.tiles = tiles.table();
  return smaller;
}

class SiteWriter {
 public:
  SiteWriter(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
             const CancelCheck& cancel_check)
      : options_(options), put_(put), cancel_check_(cancel_check), snapshot_(snapshot) {
    check(snapshot);
    if (views_of(snapshot) == 0) throw std::invalid_argument("site: the model holds no view");
    facts_.scale = site_scale(snapshot, options.most_side_px);
    facts_.views = static_cast<std::uint32_t>(views_of(snapshot));
    if (facts_.scale < 1) snapshot_ = smaller_snapshot(snapshot, facts_.scale);
  }

  // The page's own files are the caller's.
  SiteFacts write() {
    const CellShares shares = drawn_shares(*snapshot_.surface, snapshot_.references, BlendOptions{}.border_width);
    FormOptions form;
    form.photographs = options_.photographs;
    form.shares = &shares;
    form.packed = true;
    form.chunk_faces = options_.chunk_faces;
    form.coarse_faces = options_.coarse_faces;
    form.listed_views = options_.listed_views;
    const std::string tileset = write_form(
        snapshot_, options_.validity, form, [this](const FormFile& file) { return take(file); }, cancel_check_);
    facts_.scene_bytes += tileset.size();
    put_({kTilesetName, "application/json", bytes_of_text(tileset)});
    return facts_;
  }
  // Returns the name of the poster, once the scene is written; empty if there is none.
  [[nodiscard]] const std::string& poster() const { return poster_; }

 private:
  std::string take(const FormFile& file) {
    const std::lock_guard lock(mutex_);
    std::string name = name_by_content(file.stem, file.ending, file.bytes);
    if (file.part == FormPart::poster) poster_ = name;
    bytes_of(file.part) += file.bytes.size();
    put_({name, file.type, {file.bytes.begin(), file.bytes.end()}});
    return name;
  }
  std::uint64_t& bytes_of(FormPart part) {
    switch (part) {
      case FormPart::coarse:
      case FormPart::poster:
        return facts_.scene_bytes;
      case FormPart::photograph:
      case FormPart::thumbnail:
        return facts_.photograph_bytes;
      case FormPart::mask:
        return facts_.mask_bytes;
      case FormPart::surface:
      case FormPart::texture:
      case FormPart::views:
        break;
    }
    return facts_.mesh_bytes;
  }

  const SiteOptions& options_;
  const std::function<void(SiteFile)>& put_;
  std::mutex mutex_;  // guards the next three
  SiteFacts facts_;
  std::string poster_;
  CancelCheck cancel_check_;
  Snapshot snapshot_;
};

// A folder's page loads scripts, styles, pictures and data from its own site alone.
constexpr std::string_view kFolderPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'";
// A page in one file has all inside, and asks no server.
constexpr std::string_view kOnePagePolicy =
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'";

// A page's HTML before and after its script.
struct PageHtml {
  std::string before, after;
};

// What differs from page to page.
struct PageParts {
  std::string title;
  std::string attributes;  // of the <html> element
  std::string poster;      // name of the picture that is shown until the page draws; empty: the script names it later
};

PageHtml page_html(const PageParts& parts, std::string_view policy, const std::string& style) {
  constexpr std::string_view kScript = "{{script}}";
  const std::size_t script = k_page_html.find(kScript);
  if (script == std::string_view::npos) throw std::logic_error("the page has no place for its script");
  const std::string poster = parts.poster.empty() ? "hidden" : "src=\"" + html_escaped(parts.poster) + "\"";
  return {filled_template(k_page_html.substr(0, script), {{"generator", kSiteGenerator},
                                                          {"policy", std::string(policy)},
                                                          {"style", style},
                                                          {"attributes", parts.attributes},
                                                          {"poster", poster},
                                                          {"title", html_escaped(parts.title)}}),
          filled_template(k_page_html.substr(script + kScript.size()), {})};
}

// The page, with the names of its other files.
SiteFile index_file(const PageParts& parts, const std::string& style, const std::string& script) {
  const PageHtml html = page_html(parts, kFolderPolicy, "<link rel=\"stylesheet\" href=\"" + style + "\">");
  return {"index.html", "text/html; charset=utf-8",
          bytes_of_text(html.before + "<script type=\"module\" src=\"" + script + "\"></script>" + html.after)};
}

SiteFile style_file() {
  return {"viewer.css", "text/css; charset=utf-8", bytes_of_text(k_page_style)};
}

SiteFile script_file() {
  return {"viewer.js", "text/javascript; charset=utf-8", bytes_of_text(k_page_script)};
}

// The part of the <html> element that names the unit of lengths.
std::string unit_attribute(const std::string& unit) {
  return unit.empty() ? "" : " data-unit=\"" + html_escaped(unit) + "\"";
}

// The part of the <html> element that names the owner's file.
std::string page_file_attribute() {
  return std::string(" data-page-file=\"") + kPageFileName + "\"";
}

SiteFile owners_file(const std::string& text) {
  return {kPageFileName, "application/json", bytes_of_text(text)};
}

// The parts of the <html> element of a site that say what its owner and its notes say.
std::string attributes_of(const SiteOptions& options) {
  return unit_attribute(options.unit) + (options.page_file.empty() ? "" : page_file_attribute());
}

// Returns the files that a browser asks for when it opens index.html. All but index.html and the
// owner's file are named by content.
std::vector<SiteFile> lasting_page_files(const SiteOptions& options, const std::string& poster) {
  std::vector<SiteFile> files{named_by_content(style_file()), named_by_content(script_file()),
                              named_by_content(shaders_file())};
  const std::string shaders = " data-shaders=\"" + files[2].name + "\"";
  const SiteFile index =
      index_file({options.title, shaders + attributes_of(options), poster}, files[0].name, files[1].name);
  if (!options.page_file.empty()) files.push_back(owners_file(options.page_file));
  files.push_back(index);
  return files;
}

// The part of the <html> element that says what the page shows.
std::string attributes_of(const ShownModel& shown) {
  const std::string model = " data-model=\"" + html_escaped(shown.file) + "\"" + unit_attribute(shown.unit) +
                            (shown.page_file ? page_file_attribute() : "");
  return shown.live ? model + " data-live=\"live.json\"" : model;
}

}  // namespace

std::size_t site_ticks(const Snapshot& snapshot) {
  return 1 + views_of(snapshot);
}

std::vector<SiteFile> page_files(const std::string& title, const ShownModel& shown) {
  return {index_file({title, attributes_of(shown), ""}, "viewer.css", "viewer.js"), style_file(), script_file(),
          shaders_file()};
}

SiteFacts write_site(const Snapshot& snapshot, const SiteOptions& options, const std::function<void(SiteFile)>& put,
                     const CancelCheck& cancel_check) {
  SiteWriter writer(snapshot, options, put, cancel_check);
  const auto put_all = [&put](std::vector<SiteFile> files) {
    std::uint64_t bytes = 0;
    for (SiteFile& file : files) {
      bytes += file.bytes.size();
      put(std::move(file));
    }
    return bytes;
  };
  SiteFacts facts = writer.write();
  facts.other_page_bytes = put_all({script_file(), shaders_file()});
  facts.page_bytes = put_all(lasting_page_files(options, writer.poster()));
  return facts;
}

SiteFacts write_site_folder(const std::filesystem::path& folder, const Snapshot& snapshot, const SiteOptions& options,
                            const CancelCheck& cancel_check) {
  const auto put = [&](const SiteFile& file) {
    const std::filesystem::path path = folder / file.name;
    std::filesystem::create_directories(path.parent_path());
    std::ofstream stream(path, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(file.bytes.data()), static_cast<std::streamsize>(file.bytes.size()));
    if (!stream.flush()) throw InputError(path.string() + ": cannot be written, " + why_not_written());
  };
  return write_site(snapshot, options, put, cancel_check);
}

std::string title_of(const std::filesystem::path& model) {
  const std::filesystem::path name = (model / "").lexically_normal().parent_path().filename();
  return name.extension() == ".glb" ? name.stem().string() : name.string();
}

SiteFacts write_one_page(std::ostream& file, const Snapshot& snapshot, const SiteOptions& options,
                         const CancelCheck& cancel_check) {
  const PageHtml html = page_html({options.title, attributes_of(options), ""}, kOnePagePolicy,
                                  "<style>\n" + std::string(k_page_style) + "</style>");
  const std::string end = "<script type=\"module\">\n" + std::string(k_page_script) + "</script>" + html.after;
  file << html.before;
  std::uint64_t page_bytes = html.before.size() + end.size();
  const auto put = [&file](const SiteFile& part) {
    file << "<script type=\"application/octet-stream\" data-file=\"" << html_escaped(part.name) << "\" data-type=\""
         << html_escaped(part.type) << "\">";
    write_base64(file, part.bytes);
    file << "</script>\n";
  };
  const SiteFile shaders = shaders_file();
  page_bytes += shaders.bytes.size();
  put(shaders);
  if (!options.page_file.empty()) {
    page_bytes += options.page_file.size();
    put(owners_file(options.page_file));
  }
  std::map<std::string, SiteFile> parts;  // by their names, for the same bytes each time
  SiteFacts facts = SiteWriter(
                        snapshot, options,
                        [&](SiteFile part) {
                          const std::string name = part.name;
                          parts.emplace(name, std::move(part));
                        },
                        cancel_check)
                        .write();
  for (const auto& [name, part] : parts) put(part);
  file << end;
  facts.page_bytes = page_bytes;
  return facts;
}

}  // namespace lumatlas
