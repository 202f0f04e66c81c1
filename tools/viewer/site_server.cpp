// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/site_server.h"

#include <httplib.h>

#include <chrono>
#include <exception>
#include <map>
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
  std::map<std::string, SiteFile> files;
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

  void answer(const httplib::Request& request, httplib::Response& response) const {
    if (!asked_by_name(request)) {
      response.status = 403;
      return response.set_content("This address is not served by that name.\n", "text/plain");
    }
    const std::string name = request.path == "/" ? "index.html" : request.path.substr(1);
    const auto found = files.find(name);
    if (found == files.end()) {
      response.status = 404;
      return response.set_content("There is no such file.\n", "text/plain");
    }
    const SiteFile& file = found->second;
    response.set_content_provider(file.bytes.size(), file.type.c_str(),
                                  [&file](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
                                    const auto* bytes = reinterpret_cast<const char*>(&file.bytes[offset]);
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
  state_->files.insert_or_assign(std::move(name), std::move(file));
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
