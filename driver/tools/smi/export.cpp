// gicube-smi export: the boards' counters to Prometheus, over HTTP on this machine only.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <utility>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include "client.h"
#include "gicube/error.h"
#include "metrics.h"

namespace gicube::smi {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using asio::ip::tcp;

constexpr std::chrono::seconds kClientPatience{30};     // chosen: a client that returns later connects again
constexpr std::chrono::milliseconds kAcceptRetry{100};  // chosen: meanwhile descriptors may become free
constexpr const char* kMetricsPath = "/metrics";

tcp::endpoint loopback_endpoint(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  std::string host = text.substr(0, colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  if (host == "localhost") host = "127.0.0.1";
  boost::system::error_code error;
  const asio::ip::address address = asio::ip::make_address(host, error);
  const std::string digits = colon == std::string::npos ? "" : text.substr(colon + 1);
  const char* const end = digits.data() + digits.size();
  std::uint16_t port = 0;
  const auto parsed = std::from_chars(digits.data(), end, port);
  const bool is_good = !error && address.is_loopback() && parsed.ec == std::errc{} && parsed.ptr == end;
  if (!is_good) {
    throw UsageError(fmt::format(
        "--listen: expected a loopback address and a port, as 127.0.0.1:9500 (port 0: any free one), got {}", text));
  }
  return {address, port};
}

using Request = http::request<http::empty_body>;
using Response = http::response<http::string_body>;

Response answer(const Request& request) {
  Response response(http::status::ok, request.version());
  response.keep_alive(request.keep_alive());
  response.set(http::field::content_type, "text/plain; charset=utf-8");
  if (request.method() != http::verb::get && request.method() != http::verb::head) {
    response.result(http::status::method_not_allowed);
    response.set(http::field::allow, "GET, HEAD");
    response.body() = "expected GET or HEAD\n";
  } else if (request.target() != kMetricsPath) {
    response.result(http::status::not_found);
    response.body() = fmt::format("the metrics are at {}\n", kMetricsPath);
  } else {
    try {
      response.body() = metrics_text(local_processes());
      response.set(http::field::content_type, kMetricsType);
    } catch (const Error& error) {  // the registry can't be trusted
      response.result(http::status::internal_server_error);
      response.body() = fmt::format("{}\n", error.what());
    }
  }
  response.prepare_payload();
  return response;
}

// Throws when the client disconnects, or sends something other than HTTP.
asio::awaitable<void> talk(tcp::socket socket) {
  beast::tcp_stream stream(std::move(socket));
  beast::flat_buffer buffer;
  for (bool goes_on = true; goes_on;) {
    stream.expires_after(kClientPatience);
    Request request;
    co_await http::async_read(stream, buffer, request, asio::use_awaitable);
    Response response = answer(request);
    goes_on = response.keep_alive();
    if (request.method() == http::verb::head) {
      http::response_serializer<http::string_body> head(response);
      co_await http::async_write_header(stream, head, asio::use_awaitable);
    } else {
      co_await http::async_write(stream, response, asio::use_awaitable);
    }
  }
}

asio::awaitable<void> accept(tcp::acceptor& acceptor) {
  asio::steady_timer pause(acceptor.get_executor());
  for (;;) {
    tcp::socket socket(acceptor.get_executor());
    boost::system::error_code error;
    co_await acceptor.async_accept(socket, asio::redirect_error(asio::use_awaitable, error));
    if (error) {
      pause.expires_after(kAcceptRetry);
      co_await pause.async_wait(asio::use_awaitable);
    } else {
      asio::co_spawn(acceptor.get_executor(), talk(std::move(socket)), asio::detached);
    }
  }
}

}  // namespace

int export_metrics(const Options& options) {
  const tcp::endpoint endpoint = loopback_endpoint(options.listen);
  local_processes();  // throws at once if the registry can't be trusted
  asio::io_context io;
  tcp::acceptor acceptor(io);
  try {
    acceptor = tcp::acceptor(io, endpoint);
  } catch (const boost::system::system_error& error) {
    throw CallFailed(fmt::format("--listen {}: {}", options.listen, error.code().message()));
  }
  asio::signal_set signals(io, SIGINT, SIGTERM);
  signals.async_wait([&io](const boost::system::error_code&, int) { io.stop(); });
  asio::co_spawn(io, accept(acceptor), asio::detached);
  const tcp::endpoint bound = acceptor.local_endpoint();
  fmt::print("gicube-smi: metrics on http://{}:{}{}\n",
             bound.address().is_v6() ? "[" + bound.address().to_string() + "]" : bound.address().to_string(),
             bound.port(), kMetricsPath);
  std::fflush(stdout);
  io.run();
  return 0;
}

}  // namespace gicube::smi
