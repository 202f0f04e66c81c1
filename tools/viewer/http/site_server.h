// SPDX-License-Identifier: GPL-3.0-or-later
// Serves the files that it was given, from memory or a disk, and nothing else, so that no path leads anywhere.
//
// Every program that reaches the address may send anything: each request is bounded in bytes and in time, and no client
// makes another one wait (http_connection.h). Only pages that the user opened may ask (host_header.h).
//
// "/together?NAME&NAME..." answers with several files at once (files_together.h), unless a file has that name.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "tools/viewer/site.h"

namespace lumatlas {

struct ServerOptions {
  // A name or address of this machine, not empty. The loopback address is reached from this machine alone; "0.0.0.0"
  // and "::" are all addresses of this machine.
  std::string host = "127.0.0.1";
  int port = 0;  // 0: any that is free
};

class SiteServer {
 public:
  // Listens, but does not answer yet. Throws InputError if the address cannot be had.
  explicit SiteServer(const ServerOptions& options);
  ~SiteServer();
  SiteServer(const SiteServer&) = delete;
  SiteServer& operator=(const SiteServer&) = delete;

  // Serves the file in place of one of that name; index.html is also "/". The name is made of letters, digits and
  // "-._~/". This and remove() may be called from any thread while it serves.
  void add(SiteFile file);
  void remove(const std::string& name);
  // A URL that this machine's browser can open.
  [[nodiscard]] std::string address() const;
  // URLs that other machines may open, for each of this machine's IPv4 addresses, if it listens at all of them;
  // otherwise none.
  [[nodiscard]] std::vector<std::string> addresses_for_others() const;
  // Answers until `stop`, which is called about ten times a second, returns true or throws, as throw_if_interrupted()
  // does. Closes all connections then. To be called once.
  void serve(const std::function<bool()>& stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
