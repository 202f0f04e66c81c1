// SPDX-License-Identifier: GPL-3.0-or-later
// A site from memory on this machine: the files that it was given, and nothing else, so that no path leads anywhere.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "tools/viewer/site.h"

namespace lumatlas {

struct ServerOptions {
  std::string host = "127.0.0.1";  // a name or address of this machine; the loopback address is reached from here alone
  int port = 0;                    // 0: any that is free
};

class SiteServer {
 public:
  // Binds, but does not answer yet. Throws InputError if the address cannot be had.
  explicit SiteServer(const ServerOptions& options);
  ~SiteServer();
  SiteServer(const SiteServer&) = delete;
  SiteServer& operator=(const SiteServer&) = delete;

  // In place of one of that name; index.html is also "/". These two may be called from any thread while it serves.
  void add(SiteFile file);
  void remove(const std::string& name);
  [[nodiscard]] std::string address() const;  // a URL
  // Answers until `stop` says so, which is asked some times a second, or throws, as throw_if_interrupted() does.
  void serve(const std::function<bool()>& stop);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace lumatlas
