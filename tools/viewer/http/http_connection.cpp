// SPDX-License-Identifier: GPL-3.0-or-later
#include "tools/viewer/http/http_connection.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/error.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/write.hpp>
#include <utility>

namespace lumatlas {

namespace {

namespace http = boost::beast::http;
using boost::beast::error_code;

// Bounds of a request. No browser sends half as many bytes here: there are no cookies.
constexpr std::uint32_t kMostHeadBytes = 16384;
// Within this time a whole request must have come, be it the first on its connection or another one.
constexpr std::chrono::seconds kTimeForRequest{15};
// Within this time a client must take some of its answer.
constexpr std::chrono::seconds kTimeForPiece{30};
constexpr std::uint64_t kPieceBytes = 262144;
// The time and the bytes for which what a refused client still sends is thrown away, for a connection that is closed
// on unread bytes is reset and takes the refusal with it.
constexpr std::chrono::seconds kTimeToDrain{2};
constexpr std::size_t kMostDrained = 1 << 20;

unsigned status_of(error_code error) {
  if (error == http::error::header_limit || error == http::error::buffer_overflow) return 431;
  if (error == http::error::body_limit) return 413;
  return 400;
}

void add_common_headers(http::response<http::empty_body>& response) {
  response.set(http::field::cache_control, "no-store");
  response.set("Content-Security-Policy", "frame-ancestors 'none'");  // beside the page's own, in its head
  response.set("Cross-Origin-Opener-Policy", "same-origin");
  response.set("Cross-Origin-Resource-Policy", "same-origin");
  response.set("Referrer-Policy", "no-referrer");
  response.set("X-Content-Type-Options", "nosniff");
  response.set(http::field::x_frame_options, "DENY");
}

}  // namespace

OpenFile::OpenFile(const std::filesystem::path& path)
    : descriptor_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  struct stat found {};
  if (descriptor_ < 0) return;
  if (fstat(descriptor_, &found) == 0 && S_ISREG(found.st_mode)) {
    size_ = static_cast<std::uint64_t>(found.st_size);
    return;
  }
  close(descriptor_);
  descriptor_ = -1;
}

OpenFile::~OpenFile() {
  if (is_open()) close(descriptor_);
}

std::size_t OpenFile::read(std::uint64_t offset, std::span<char> piece) const {
  const ssize_t count = pread(descriptor_, piece.data(), piece.size(), static_cast<off_t>(offset));
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

SiteAnswer refusal(unsigned status, const std::string& sentence) {
  const std::string line = sentence + '\n';
  auto text = std::make_shared<const SiteFile>(SiteFile{"", "text/plain; charset=utf-8", {line.begin(), line.end()}});
  const std::uint64_t length = text->bytes.size();
  return {status, std::move(text), 0, length, false, 0, nullptr};
}

// Lives as long as one of its operations waits.
class HttpConnections::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(HttpConnections& all, boost::asio::ip::tcp::socket socket)
      : all_(all), place_(all.open_.insert(all.open_.end(), this)), stream_(std::move(socket)) {}
  ~Connection() { leave(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start() {
    error_code ignored;
    stream_.socket().set_option(boost::asio::ip::tcp::no_delay(true), ignored);
    read_request();
  }
  void close() {
    leave();
    error_code ignored;
    stream_.socket().close(ignored);
  }

 private:
  void leave() {
    if (is_listed_) all_.open_.erase(place_);
    is_listed_ = false;
  }
  void note_progress() {
    if (is_listed_) all_.open_.splice(all_.open_.end(), all_.open_, place_);
  }

  void read_request() {
    parser_.emplace();
    parser_->header_limit(kMostHeadBytes);
    stream_.expires_after(kTimeForRequest);
    http::async_read_header(stream_, buffer_, *parser_,
                            [self = shared_from_this()](error_code error, std::size_t) { self->take_request(error); });
  }

  void take_request(error_code error) {
    const auto& asked = parser_->get();
    if (error) {
      // A malformed request ends the connection, with an answer if the client can still read one.
      const bool is_malformed = error.category() == http::make_error_code(http::error::bad_method).category();
      const bool is_over = error == http::error::end_of_stream || error == http::error::partial_message;
      if (!is_malformed || is_over) return close();
      return refuse(status_of(error), "This is no request that is understood here.");
    }
    note_progress();
    if (asked.method() != http::verb::get && asked.method() != http::verb::head) {
      return refuse(405, "Only GET and HEAD are answered here.");
    }
    const bool has_body = parser_->chunked() || parser_->content_length().value_or(0) > 0;
    if (has_body || asked.target().empty() || asked.target().front() != '/' || asked.count(http::field::host) != 1) {
      return refuse(400, "This is no request for a file.");
    }
    answer(all_.handler_(site_request()), asked.keep_alive());
  }

  [[nodiscard]] SiteRequest site_request() const {
    const auto& asked = parser_->get();
    SiteRequest request;
    const std::string target(asked.target());
    const std::size_t path_end = std::min(target.find('?'), target.size());
    request.path = target.substr(0, path_end);
    if (path_end < target.size()) request.query = target.substr(path_end + 1);
    request.host = std::string(asked[http::field::host]);
    // Answers carry no validator that a condition could hold of. Two Range headers are none.
    const bool has_range = asked.method() == http::verb::get && asked.count(http::field::range) == 1 &&
                           asked.count(http::field::if_range) == 0;
    if (has_range) request.range = std::string(asked[http::field::range]);
    return request;
  }

  void refuse(unsigned status, const std::string& sentence) { answer(refusal(status, sentence), false); }

  void answer(SiteAnswer answer, bool keep_open) {
    answer_ = std::move(answer);
    const auto& asked = parser_->get();
    response_ = {};
    response_.version(11);
    response_.result(answer_.status);
    response_.keep_alive(keep_open);
    if (asked.version() == 10 && keep_open) response_.set(http::field::connection, "keep-alive");
    add_common_headers(response_);
    response_.set(http::field::content_type, answer_.file->type);
    response_.set(http::field::content_length, std::to_string(answer_.length));
    if (answer_.in_parts) response_.set(http::field::accept_ranges, "bytes");
    if (answer_.status == 206) {
      response_.set(http::field::content_range, "bytes " + std::to_string(answer_.offset) + '-' +
                                                    std::to_string(answer_.offset + answer_.length - 1) + '/' +
                                                    std::to_string(answer_.size()));
    }
    if (answer_.status == 416) response_.set(http::field::content_range, "bytes */" + std::to_string(answer_.of_size));
    if (answer_.status == 405) response_.set(http::field::allow, "GET, HEAD");
    if (asked.method() == http::verb::head) answer_.length = 0;
    keep_open_ = keep_open;
    write_head();
  }

  void write_head() {
    serializer_.emplace(response_);
    stream_.expires_after(kTimeForPiece);
    http::async_write_header(stream_, *serializer_, [self = shared_from_this()](error_code error, std::size_t) {
      if (error) return self->close();
      self->write_piece();
    });
  }

  void write_piece() {
    if (answer_.length == 0) return finish();
    const std::uint64_t size = std::min(answer_.length, kPieceBytes);
    const char* first = bytes_at(answer_.offset, size);
    if (!first) return close();  // the file became shorter
    const auto piece = boost::asio::buffer(first, size);
    stream_.expires_after(kTimeForPiece);
    stream_.async_write_some(piece, [self = shared_from_this()](error_code error, std::size_t sent) {
      if (error) return self->close();
      self->note_progress();
      self->answer_.offset += sent;
      self->answer_.length -= sent;
      self->write_piece();
    });
  }

  // Null: they cannot be read.
  const char* bytes_at(std::uint64_t offset, std::uint64_t size) {
    if (!answer_.disk) return reinterpret_cast<const char*>(answer_.file->bytes.data()) + offset;
    piece_.resize(size);
    return answer_.disk->read(offset, piece_) == size ? piece_.data() : nullptr;
  }

  void finish() {
    answer_ = {};
    piece_ = {};
    if (keep_open_) return read_request();
    error_code ignored;
    stream_.socket().shutdown(boost::asio::ip::tcp::socket::shutdown_send, ignored);
    stream_.expires_after(kTimeToDrain);
    drain(0);
  }

  void drain(std::size_t drained) {
    if (drained > kMostDrained) return close();
    stream_.async_read_some(boost::asio::buffer(drained_),
                            [self = shared_from_this(), drained](error_code error, std::size_t received) {
                              if (error) return self->close();
                              self->drain(drained + received);
                            });
  }

  HttpConnections& all_;
  std::list<Connection*>::iterator place_;
  bool is_listed_ = true;
  boost::beast::tcp_stream stream_;
  boost::beast::flat_buffer buffer_{2 * kMostHeadBytes};  // received bytes of this request and the next ones
  std::optional<http::request_parser<http::empty_body>> parser_;
  SiteAnswer answer_;        // the part that is still to be sent
  std::vector<char> piece_;  // of a file on a disk, what is being sent
  http::response<http::empty_body> response_;
  std::optional<http::response_serializer<http::empty_body>> serializer_;
  bool keep_open_ = false;
  std::array<char, 4096> drained_{};
};

HttpConnections::HttpConnections(SiteHandler handler) : handler_(std::move(handler)) {}

HttpConnections::~HttpConnections() = default;

void HttpConnections::open(boost::asio::ip::tcp::socket socket) {
  if (open_.size() >= kMost) close_stalest();
  std::make_shared<Connection>(*this, std::move(socket))->start();
}

void HttpConnections::close_stalest() {
  if (!open_.empty()) open_.front()->close();
}

void HttpConnections::close_all() {
  while (!open_.empty()) close_stalest();
}

}  // namespace lumatlas
