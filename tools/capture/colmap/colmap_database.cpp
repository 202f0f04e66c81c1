// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/capture/colmap/colmap_database.h"

#include <sqlite3.h>

#include <memory>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

}  // namespace

std::map<std::string, std::uint32_t> image_ids(const std::filesystem::path& database) {
  sqlite3* opened = nullptr;
  const int open_status = sqlite3_open_v2(database.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
  const std::unique_ptr<sqlite3, Close> connection(opened);
  const auto fail = [&] {
    throw InputError(database.string() + ": cannot be read as COLMAP's database (" + sqlite3_errmsg(opened) + ")");
  };
  if (open_status != SQLITE_OK) fail();
  sqlite3_stmt* prepared = nullptr;
  const int prepare_status = sqlite3_prepare_v2(opened, "SELECT name, image_id FROM images", -1, &prepared, nullptr);
  const std::unique_ptr<sqlite3_stmt, Close> statement(prepared);
  if (prepare_status != SQLITE_OK) fail();
  std::map<std::string, std::uint32_t> ids;
  int status = sqlite3_step(prepared);
  for (; status == SQLITE_ROW; status = sqlite3_step(prepared)) {
    const auto* const name = reinterpret_cast<const char*>(sqlite3_column_text(prepared, 0));
    const sqlite3_int64 id = sqlite3_column_int64(prepared, 1);
    if (name != nullptr && id > 0 && id <= 0x7fffffff) ids.emplace(name, static_cast<std::uint32_t>(id));
  }
  if (status != SQLITE_DONE) fail();
  return ids;
}

}  // namespace lumatlas
