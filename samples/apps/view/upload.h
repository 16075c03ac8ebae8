// The body of POST /file. server.cpp alone includes this.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it
#include <vector>

#include "view/door.h"
#include "view/posted.h"
#include "view/protocol.h"

#include <boost/asio/awaitable.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

namespace gicube::samples::view {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::awaitable;
using boost::system::error_code;
using Parser = http::request_parser<http::empty_body>;

inline auto into(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }
inline std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

// Throws Refusal, and boost::system::system_error. S: a stream of TCP or TLS.
template <typename S>
awaitable<void> take_file(S& stream, beast::flat_buffer& buffer, Parser& head, PostedFiles& files,
                          const std::string& name) {
  http::request_parser<http::buffer_body> parser(std::move(head));
  const Refusal too_large{http::status::payload_too_large,
                          fmt::format("a file: expected at most {} bytes with all that were posted", kMaxFileBytes)};
  PostedFiles::Part part(files, name);
  const bool is_told = parser.content_length().has_value();
  if (is_told && !part.take(*parser.content_length())) throw too_large;
  if (view_of(parser.get()[http::field::expect]) == "100-continue") {
    http::response<http::empty_body> go_on(http::status::continue_, 11);
    co_await http::async_write(stream, go_on, asio::use_awaitable);
  }
  std::vector<char> bytes(std::size_t{1} << 18);
  while (!parser.is_done()) {
    parser.get().body().data = bytes.data();
    parser.get().body().size = bytes.size();
    beast::get_lowest_layer(stream).expires_after(kRequestTime);
    error_code error;
    co_await http::async_read(stream, buffer, parser, into(error));
    if (error && error != http::error::need_buffer) throw boost::system::system_error(error);
    const std::size_t count = bytes.size() - parser.get().body().size;
    if (!is_told && !part.take(count)) throw too_large;
    part.write({bytes.data(), count});
  }
  if (!part.keep()) throw Refusal{http::status::insufficient_storage, "a file: expected a disk with room for it"};
}

// Reads and discards the rest of a refused body for a while: closing with unread bytes could lose the answer.
template <typename S>
awaitable<void> linger(S& stream) {
  std::vector<char> bytes(std::size_t{1} << 18);
  beast::get_lowest_layer(stream).expires_after(kRequestTime);
  error_code error;
  beast::get_lowest_layer(stream).socket().shutdown(asio::ip::tcp::socket::shutdown_send, error);
  for (error = {}; !error;) co_await stream.async_read_some(asio::buffer(bytes), into(error));
}

}  // namespace gicube::samples::view
