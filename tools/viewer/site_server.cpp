// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/site_server.h"

#include <httplib.h>

#include <chrono>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "mesh/base/errors.h"

namespace lumatlas {

namespace {

bool is_local(const std::string& host) {
  return host == "127.0.0.1" || host == "localhost" || host == "::1";
}

std::string in_url(const std::string& host) {
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

}  // namespace

struct SiteServer::State {
  ServerOptions options;
  httplib::Server server;
  std::mutex mutex;  // of the files
  std::map<std::string, std::shared_ptr<const SiteFile>> files;
  int port = 0;

  // Another site's name that leads to this address (DNS rebinding) is refused.
  [[nodiscard]] bool asked_by_name(const httplib::Request& request) const {
    if (!is_local(options.host)) return true;
    const std::string host = request.get_header_value("Host");
    for (const char* name : {"127.0.0.1", "localhost", "[::1]"}) {
      if (host == std::string(name) + ":" + std::to_string(port)) return true;
    }
    return false;
  }

  // Null: there is none.
  [[nodiscard]] std::shared_ptr<const SiteFile> file(const std::string& name) {
    const std::lock_guard lock(mutex);
    const auto found = files.find(name);
    return found == files.end() ? nullptr : found->second;
  }

  void answer(const httplib::Request& request, httplib::Response& response) {
    if (!asked_by_name(request)) {
      response.status = 403;
      return response.set_content("This address is not served by that name.\n", "text/plain");
    }
    const std::string name = request.path == "/" ? "index.html" : request.path.substr(1);
    const std::shared_ptr<const SiteFile> found = file(name);
    if (!found) {
      response.status = 404;
      return response.set_content("There is no such file.\n", "text/plain");
    }
    // It is kept for whoever fetches it, although another may come in its place.
    response.set_content_provider(found->bytes.size(), found->type.c_str(),
                                  [found](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                    const auto* bytes = reinterpret_cast<const char*>(&found->bytes[offset]);
                                    return sink.write(bytes, length);
                                  });
  }
};

SiteServer::SiteServer(const ServerOptions& options) : state_(std::make_unique<State>()) {
  State& state = *state_;
  state.options = options;
  state.server.set_default_headers(
      {{"X-Content-Type-Options", "nosniff"},
       {"X-Frame-Options", "DENY"},
       {"Content-Security-Policy", "frame-ancestors 'none'"},  // beside the page's own, in its head
       {"Cross-Origin-Opener-Policy", "same-origin"},
       {"Cross-Origin-Resource-Policy", "same-origin"},
       {"Referrer-Policy", "no-referrer"},
       {"Cache-Control", "no-store"}});
  state.server.set_tcp_nodelay(true);
  state.server.Get(".*", [&state](const httplib::Request& request, httplib::Response& response) {
    state.answer(request, response);
  });
  // Only this program's port: without SO_REUSEPORT, which httplib sets, another one could not share it.
  state.server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  });
  state.port = options.port == 0                                       ? state.server.bind_to_any_port(options.host)
               : state.server.bind_to_port(options.host, options.port) ? options.port
                                                                       : -1;
  if (state.port <= 0) {
    throw InputError(options.host + (options.port == 0 ? "" : ":" + std::to_string(options.port)) +
                     ": cannot be listened at, is the port taken, or the address another machine's?");
  }
}

SiteServer::~SiteServer() = default;

void SiteServer::add(SiteFile file) {
  std::string name = file.name;
  auto shared = std::make_shared<const SiteFile>(std::move(file));
  const std::lock_guard lock(state_->mutex);
  state_->files.insert_or_assign(std::move(name), std::move(shared));
}

void SiteServer::remove(const std::string& name) {
  const std::lock_guard lock(state_->mutex);
  state_->files.erase(name);
}

std::string SiteServer::address() const {
  return "http://" + in_url(state_->options.host) + ":" + std::to_string(state_->port) + "/";
}

void SiteServer::serve(const std::function<bool()>& stop) {
  constexpr auto kBetweenQuestions = std::chrono::milliseconds(100);
  std::thread answering([this] { state_->server.listen_after_bind(); });
  // Until it answers there is nothing that could be told to stop.
  while (!state_->server.is_running()) std::this_thread::sleep_for(kBetweenQuestions / 20);
  std::exception_ptr thrown;
  try {
    while (!stop()) std::this_thread::sleep_for(kBetweenQuestions);
  } catch (...) {
    thrown = std::current_exception();
  }
  state_->server.stop();
  answering.join();
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace lumatlas
