// SPDX-License-Identifier: GPL-3.0-or-later
// One client's connection to the server of a site: reads its requests and writes the answers, without a thread of its
// own. All connections run on the thread that runs their io_context. A client that sends slowly, or reads slowly, costs
// a descriptor and some kilobytes, and none of the others waits for it.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "tools/viewer/site.h"

namespace lumatlas {

// A request as far as the site is concerned; it has passed the parser, and has no body.
struct SiteRequest {
  std::string path;                  // from the first '/', without the query
  std::string query;                 // after the '?'; empty: there is none
  std::string host;                  // value of the Host header
  std::optional<std::string> range;  // value of the Range header, of a GET without conditions
};

// A file on a disk, open for reading; it stays as it is if another one takes its name.
class OpenFile {
 public:
  // Opens a regular file; is_open() says whether that succeeded.
  explicit OpenFile(const std::filesystem::path& path);
  ~OpenFile();
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;

  [[nodiscard]] bool is_open() const { return descriptor_ >= 0; }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  // Returns as many bytes from `offset` as can be read, at most those of `piece`; 0 if none can be.
  [[nodiscard]] std::size_t read(std::uint64_t offset, std::span<char> piece) const;

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

// The answer to a request: a file, or a part of it.
struct SiteAnswer {
  unsigned status = 200;
  std::shared_ptr<const SiteFile> file;  // never null; kept while it is being sent
  std::uint64_t offset = 0, length = 0;  // within the file's bytes
  bool in_parts = true;                  // parts of it may be asked for
  std::uint64_t of_size = 0;             // with status 416, the size of the file that was asked for
  std::shared_ptr<const OpenFile> disk;  // where the file's bytes are; null: in the file

  // The size of the whole file.
  [[nodiscard]] std::uint64_t size() const { return disk ? disk->size() : file->bytes.size(); }
};

// A refusal with a line of text.
[[nodiscard]] SiteAnswer refusal(unsigned status, const std::string& sentence);

using SiteHandler = std::function<SiteAnswer(const SiteRequest&)>;

// The connections that are open, so that there is an end to their number.
class HttpConnections {
 public:
  // More than browsers open, and fewer than the descriptors that a process may have by default.
  static constexpr std::size_t kMost = 200;

  // Must outlive the io_context of the sockets.
  explicit HttpConnections(SiteHandler handler);
  ~HttpConnections();
  HttpConnections(const HttpConnections&) = delete;
  HttpConnections& operator=(const HttpConnections&) = delete;

  // Answers what the client asks. Where there are too many connections already, the one that has gone without progress
  // for the longest time is closed.
  void open(boost::asio::ip::tcp::socket socket);
  // Closes the one that has gone without progress for the longest time, if there is one.
  void close_stalest();
  void close_all();

 private:
  class Connection;
  SiteHandler handler_;
  std::list<Connection*> open_;  // in the order of their last progress, the stalest first
};

}  // namespace lumatlas
