// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/http/site_server.h"

#include <ifaddrs.h>
#include <netinet/in.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mesh/base/errors.h"
#include "tools/viewer/http/byte_range.h"
#include "tools/viewer/http/files_together.h"
#include "tools/viewer/http/host_header.h"
#include "tools/viewer/http/http_connection.h"

namespace lumatlas {

namespace {

namespace asio = boost::asio;
using asio::ip::tcp;

constexpr std::chrono::milliseconds kBetweenQuestions{100};
constexpr const char* kTogetherPath = "/together";

std::string site_url(const std::string& host, unsigned port) {
  const std::string in_url = host.find(':') == std::string::npos ? host : "[" + host + "]";
  return "http://" + in_url + ":" + std::to_string(port) + "/";
}

// The file, or as much of it as the range says.
SiteAnswer answer_with(std::shared_ptr<const SiteFile> file, const std::optional<std::string>& range) {
  SiteAnswer answer;
  if (!file->path.empty()) {
    answer.disk = std::make_shared<const OpenFile>(file->path);
    if (!answer.disk->is_open()) return refusal(404, "There is no such file any more.");
  }
  answer.file = std::move(file);
  const std::uint64_t size = answer.size();
  const ByteRange asked = range ? byte_range(*range, size) : ByteRange{};
  switch (asked.answer) {
    case ByteRange::Answer::part:
      answer.status = 206;
      answer.offset = asked.offset;
      answer.length = asked.length;
      return answer;
    case ByteRange::Answer::unsatisfiable: {
      SiteAnswer none = refusal(416, "The file has no such bytes.");
      none.of_size = size;
      return none;
    }
    case ByteRange::Answer::whole:
      break;
  }
  answer.length = size;
  return answer;
}

}  // namespace

struct SiteServer::State {
  ServerOptions options;
  std::mutex mutex;  // guards the files
  std::map<std::string, std::shared_ptr<const SiteFile>> files;
  // In the order in which they are needed: what waits on the io_context is destroyed with it.
  HttpConnections connections{[this](const SiteRequest& request) { return answer(request); }};
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::steady_timer pause{io};

  // Null: there is none.
  [[nodiscard]] std::shared_ptr<const SiteFile> file(const std::string& name) {
    const std::lock_guard lock(mutex);
    const auto found = files.find(name);
    return found == files.end() ? nullptr : found->second;
  }

  [[nodiscard]] std::shared_ptr<const SiteFile> together(const std::string& query) {
    std::vector<std::uint8_t> bytes = files_together(query, [this](const std::string& name) { return file(name); });
    return std::make_shared<const SiteFile>(SiteFile{"together", "application/octet-stream", std::move(bytes), {}});
  }

  [[nodiscard]] SiteAnswer answer(const SiteRequest& request) {
    if (!names_this_server(request.host, options.host)) {
      return refusal(403,
                     "This is not served by that name: open it by its address in numbers, or give --host the name.");
    }
    std::shared_ptr<const SiteFile> found = file(request.path == "/" ? "index.html" : request.path.substr(1));
    if (!found && request.path == kTogetherPath && !request.query.empty()) found = together(request.query);
    return found ? answer_with(std::move(found), request.range) : refusal(404, "There is no such file.");
  }

  // The first of the host's addresses that can be had.
  void listen() {
    boost::system::error_code error;
    const auto found = tcp::resolver(io).resolve(options.host, std::to_string(options.port),
                                                 tcp::resolver::passive | tcp::resolver::numeric_service, error);
    for (const auto& entry : found) {
      if (listens_at(entry.endpoint(), error)) return;
    }
    throw InputError(options.host + (options.port == 0 ? "" : ":" + std::to_string(options.port)) +
                     ": cannot be listened at: " + error.message());
  }

  [[nodiscard]] bool listens_at(const tcp::endpoint& endpoint, boost::system::error_code& error) {
    acceptor = tcp::acceptor(io);
    acceptor.open(endpoint.protocol(), error);
    // With SO_REUSEPORT another program could share the port.
    if (!error) acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    boost::system::error_code ignored;
    if (endpoint.address().is_v6()) acceptor.set_option(asio::ip::v6_only(false), ignored);
    if (!error) acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(tcp::acceptor::max_listen_connections, error);
    return !error;
  }

  void accept() {
    acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return accept_later();
      accept();
      connections.open(std::move(socket));
    });
  }

  // If descriptors or memory run out, closing one connection leaves room for the next.
  void accept_later() {
    connections.close_stalest();
    pause.expires_after(kBetweenQuestions / 10);
    pause.async_wait([this](boost::system::error_code error) {
      if (!error) accept();
    });
  }
};

SiteServer::SiteServer(const ServerOptions& options) : state_(std::make_unique<State>()) {
  if (options.host.empty()) throw std::invalid_argument("ServerOptions: host is empty, must be a name or an address");
  state_->options = options;
  state_->listen();
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
  const tcp::endpoint local = state_->acceptor.local_endpoint();
  std::string host = state_->options.host;
  if (local.address().is_unspecified()) host = local.address().is_v6() ? "::1" : "127.0.0.1";
  return site_url(host, local.port());
}

std::vector<std::string> SiteServer::addresses_for_others() const {
  std::vector<std::string> addresses;
  const tcp::endpoint local = state_->acceptor.local_endpoint();
  ifaddrs* interfaces = nullptr;
  if (!local.address().is_unspecified() || getifaddrs(&interfaces) != 0) return addresses;
  for (const ifaddrs* one = interfaces; one; one = one->ifa_next) {
    if (!one->ifa_addr || one->ifa_addr->sa_family != AF_INET) continue;
    const auto* socket_address = reinterpret_cast<const sockaddr_in*>(one->ifa_addr);
    const asio::ip::address_v4 address(ntohl(socket_address->sin_addr.s_addr));
    if (!address.is_loopback()) addresses.push_back(site_url(address.to_string(), local.port()));
  }
  freeifaddrs(interfaces);
  return addresses;
}

void SiteServer::serve(const std::function<bool()>& stop) {
  State& state = *state_;
  // Clients that are connected learn of the end, also of one by an exception.
  const auto end = [](State* ended) {
    boost::system::error_code ignored;
    ended->acceptor.close(ignored);
    ended->connections.close_all();
  };
  const std::unique_ptr<State, decltype(end)> ends(&state, end);
  state.accept();
  while (!stop()) state.io.run_for(kBetweenQuestions);
}

}  // namespace lumatlas
