#include "view/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <map>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it

#include "gicube/guests.h"
#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "view/door.h"
#include "view/outbox.h"
#include "view/page_files.h"
#include "view/protocol.h"
#include "view/upload.h"

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/host_name.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/ssl.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>

namespace gicube::samples::view {
namespace {

namespace websocket = beast::websocket;
using asio::ip::tcp;
using Tls = beast::ssl_stream<beast::tcp_stream>;
using HttpRequest = http::request<http::empty_body>;

constexpr std::size_t kHeaderBytes = 8192;              // chosen: browsers' are below 2 KiB
constexpr std::chrono::milliseconds kAcceptRetry{100};  // chosen: until a descriptor may be free again
constexpr std::chrono::seconds kIdle{60};               // chosen: between requests of a client with the token

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

}  // namespace

struct Server::State {
  struct Visitor {
    std::string address;
    beast::tcp_stream* stream = nullptr;  // null: the WebSocket owns it
    bool knows = false;                   // whether it has the token, and is in the queue of guests
    const std::string& host() const { return address; }
  };
  using Visiting = std::shared_ptr<Visitor>;
  struct Client {
    Outbox out;
    asio::steady_timer wake;
    bool is_gone = false;
    std::function<void()> close;  // ends pending operations on the connection
    explicit Client(asio::io_context& io) : wake(io, asio::steady_timer::time_point::max()) {}
  };

  Pages pages;
  Door door;
  Guests<Visitor> guests{kMaxConnections, kMaxConnections};  // must outlive io
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::signal_set signals{io};
  std::map<Page, std::shared_ptr<Client>> clients;
  Page last_page = kAllPages;

  awaitable<void> accept();
  void serve(tcp::socket socket);
  // S: a stream of TCP or TLS.
  template <typename S>
  awaitable<void> connection(S stream);
  template <typename S>
  awaitable<bool> answer(S& stream, beast::flat_buffer& buffer, Parser& parser, Visiting visitor);
  template <typename S>
  awaitable<bool> reply(S& stream, const HttpRequest& request, http::status status, std::string_view type,
                        std::string body, const std::string& attachment = {});
  template <typename S>
  awaitable<void> page(S stream, HttpRequest request);
  template <typename S>
  awaitable<void> write_out(S& socket, std::shared_ptr<Client> client, std::shared_ptr<bool> ended);
  void put(Client& client, const Packet& packet);
};

// Returns whether the connection may send another request.
template <typename S>
awaitable<bool> Server::State::answer(S& stream, beast::flat_buffer& buffer, Parser& parser, Visiting visitor) {
  const HttpRequest request = parser.get();  // take_file() empties the parser's
  std::optional<Refusal> refusal;
  std::optional<Viewer::Download> found;
  bool is_page = false, is_file = false;
  try {
    const bool is_get = request.method() == http::verb::get;
    const Target target = target_of(view_of(request.target()));
    is_page = is_get && target.path == "/socket";
    is_file = request.method() == http::verb::post && target.path == "/file";
    door.check(view_of(request[http::field::host]), view_of(request[http::field::origin]), is_page || is_file);
    if (is_get && parser.content_length_remaining().value_or(0) > 0)
      throw Refusal{http::status::bad_request, "a body: expected none"};
    if (parser.chunked() && is_get) throw Refusal{http::status::bad_request, "a body: expected none"};
    if (is_page || is_file || target.path == "/" || target.path == "/download") {
      door.check_token(target);
      if (!guests.enqueue(visitor).empty()) throw Refusal{http::status::service_unavailable, "too many connections"};
      visitor->knows = true;
    }
    if (is_file) {
      const std::string name = target.value("name");
      if (!is_file_name(name))
        throw Refusal{http::status::bad_request, "name: expected a file's name, without folders"};
      co_await take_file(stream, buffer, parser, *pages.files, name);
      co_return co_await reply(stream, request, http::status::no_content, "text/plain", "");
    }
    if (!is_get) throw Refusal{http::status::bad_request, "expected GET, or POST /file"};
    if (is_page && !websocket::is_upgrade(request)) throw Refusal{http::status::bad_request, "expected a WebSocket"};
    if (!is_page && target.path == "/download") {
      found = pages.download(target.value("what"), parse_number<std::uint64_t>(target.value("number")).value_or(0));
      if (!found)
        throw Refusal{http::status::not_found, "what: expected png, exr, stats or tf of a picture that is there"};
    } else if (!is_page) {
      const std::string name = target.path == "/" ? "index.html" : target.path.substr(1);
      const auto file = std::ranges::find(page_files(), name, &PageFile::name);
      if (file == page_files().end() || (name == "index.html" && target.path != "/"))
        throw Refusal{http::status::not_found, "no such file"};
      found = Viewer::Download{"", std::string(file->type), std::string(file->content)};
    }
  } catch (const Refusal& reason) {
    refusal = reason;
  } catch (const Error& error) {
    refusal = Refusal{http::status::internal_server_error, error.what()};
  }
  if (refusal) {
    co_await reply(stream, request, refusal->status, "text/plain", refusal->text + '\n');
    if (is_file && visitor->knows) co_await linger(stream);
    co_return false;
  }
  if (is_page) {
    HttpRequest upgrade = request;
    visitor->stream = nullptr;
    co_await page(std::move(stream), std::move(upgrade));
    co_return false;
  }
  co_return co_await reply(stream, request, http::status::ok, found->type, std::move(found->bytes), found->name);
}

template <typename S>
awaitable<bool> Server::State::reply(S& stream, const HttpRequest& request, http::status status, std::string_view type,
                                     std::string body, const std::string& attachment) {
  http::response<http::string_body> response(status, 11, std::move(body));
  const bool goes_on = request.keep_alive() && to_status_class(status) == http::status_class::successful;
  const auto set = [&response](const char* name, std::string_view value) {
    response.set(name, beast::string_view(value.data(), value.size()));
  };
  set("Content-Type", std::string(type) + (type.starts_with("text/") ? "; charset=utf-8" : ""));
  set("Content-Security-Policy", kPolicy);
  set("X-Content-Type-Options", "nosniff");
  set("Referrer-Policy", "no-referrer");
  set("Cache-Control", "no-store");
  set("Cross-Origin-Opener-Policy", "same-origin");
  set("Cross-Origin-Resource-Policy", "same-origin");
  if (!attachment.empty()) set("Content-Disposition", "attachment; filename=\"" + attachment + '"');
  response.keep_alive(goes_on);
  response.prepare_payload();
  beast::get_lowest_layer(stream).expires_after(kIdle);
  co_await http::async_write(stream, response, asio::use_awaitable);
  co_return goes_on;
}

awaitable<void> Server::State::accept() {
  for (;;) {
    error_code error;
    tcp::socket socket = co_await acceptor.async_accept(into(error));
    if (error == asio::error::operation_aborted) co_return;
    if (error) {
      asio::steady_timer pause(io, kAcceptRetry);
      co_await pause.async_wait(into(error));
      continue;
    }
    serve(std::move(socket));
  }
}

void Server::State::serve(tcp::socket socket) {
  error_code ignored;
  socket.set_option(tcp::no_delay(true), ignored);
  if (door.tls) {
    asio::co_spawn(io, connection(Tls(std::move(socket), *door.tls)), asio::detached);
  } else {
    asio::co_spawn(io, connection(beast::tcp_stream(std::move(socket))), asio::detached);
  }
}

template <typename S>
awaitable<void> Server::State::connection(S stream) {
  beast::tcp_stream& plain = beast::get_lowest_layer(stream);
  error_code none;
  const Visiting visitor(new Visitor{plain.socket().remote_endpoint(none).address().to_string(), &plain});
  const std::shared_ptr<void> left(nullptr, [this, visitor](void*) { guests.leave(visitor); });
  if (const Visiting out = guests.enter(visitor); out && out->stream != nullptr) out->stream->close();
  try {
    if constexpr (std::is_same_v<S, Tls>) {
      plain.expires_after(kRequestTime);
      co_await stream.async_handshake(Tls::server, asio::use_awaitable);
    }
    beast::flat_buffer buffer(2 * kHeaderBytes);
    for (bool goes_on = true; goes_on;) {
      error_code error;
      Parser parser;
      parser.header_limit(kHeaderBytes);
      parser.body_limit(~std::uint64_t{0});  // limited by PostedFiles
      plain.expires_after(visitor->knows && buffer.size() == 0 ? kIdle : std::chrono::seconds(kRequestTime));
      co_await http::async_read_header(stream, buffer, parser, into(error));
      if (error == http::error::header_limit) {
        co_await reply(stream, {}, http::status::request_header_fields_too_large, "text/plain", "too long a header\n");
      }
      if (error) break;
      goes_on = co_await answer(stream, buffer, parser, visitor);
    }
  } catch (const std::exception&) {
    // The client has disconnected, or took too long.
  }
}

template <typename S>
awaitable<void> Server::State::page(S stream, HttpRequest request) {
  beast::get_lowest_layer(stream).expires_never();  // the WebSocket has its own limits
  websocket::stream<S, false> socket(std::move(stream));  // without deflate: pictures are PNG
  socket.read_message_max(kMaxMessageBytes);
  socket.auto_fragment(false);
  socket.write_buffer_bytes(std::size_t{1} << 18);
  websocket::stream_base::timeout limits = websocket::stream_base::timeout::suggested(beast::role_type::server);
  limits.handshake_timeout = kRequestTime;
  socket.set_option(limits);
  error_code error;
  co_await socket.async_accept(request, into(error));
  if (error) co_return;
  const Page number = ++last_page;
  auto client = std::make_shared<Client>(io);
  client->close = [&socket] { beast::get_lowest_layer(socket).close(); };
  clients[number] = client;
  auto ended = std::make_shared<bool>(false);
  asio::co_spawn(io, write_out(socket, client, ended), asio::detached);
  pages.come(number);
  websocket::close_reason reason(websocket::close_code::normal);
  bool is_fault = false;
  while (!client->is_gone) {
    beast::flat_buffer buffer(kMaxMessageBytes);
    co_await socket.async_read(buffer, into(error));
    if (error) break;
    const auto data = buffer.data();
    try {
      if (!socket.got_text()) throw InputError("message", "text", "bytes");
      pages.ask(number, parse_request({static_cast<const char*>(data.data()), data.size()}));
    } catch (const InputError& fault) {
      reason = {websocket::close_code::policy_error, std::string(fault.what()).substr(0, 120)};
      is_fault = true;
      break;
    }
  }
  clients.erase(number);
  pages.leave(number);
  client->is_gone = true;
  client->out.clear();
  client->wake.cancel();
  if (!is_fault) beast::get_lowest_layer(socket).close();
  asio::steady_timer pause(io);
  constexpr int kPatience = 1000;  // chosen: milliseconds for a pending write, before the reason is sent
  for (int i = 0; !*ended; ++i) {  // write_out() uses the socket
    if (i == kPatience) beast::get_lowest_layer(socket).close();
    pause.expires_after(std::chrono::milliseconds(1));
    co_await pause.async_wait(into(error));
  }
  if (is_fault) co_await socket.async_close(reason, into(error));
}

template <typename S>
awaitable<void> Server::State::write_out(S& socket, std::shared_ptr<Client> client, std::shared_ptr<bool> ended) {
  error_code error;
  while (!client->is_gone) {
    if (client->out.empty()) {
      co_await client->wake.async_wait(into(error));
      continue;
    }
    const Packet packet = client->out.take();
    socket.binary(packet.binary);
    co_await socket.async_write(asio::buffer(*packet.bytes), into(error));
    if (error) break;
  }
  *ended = true;
}

// A page that is too slow is disconnected, and its messages are dropped.
void Server::State::put(Client& client, const Packet& packet) {
  if (client.is_gone) return;
  client.is_gone = !client.out.put(packet);
  if (client.is_gone) client.close();
  client.wake.cancel();
}

Server::Server(Pages pages, std::string token) : state_(std::make_unique<State>()) {
  state_->pages = std::move(pages);
  state_->door.token = std::move(token);
}

Server::Server(Pages pages, const Listen& listen, std::string token) : Server(std::move(pages), std::move(token)) {
  const asio::ip::address address = asio::ip::make_address(listen.address);
  if (!listen.certificate_file.empty()) state_->door.speak_tls(listen.certificate_file, listen.key_file);
  const tcp::endpoint endpoint(address, listen.port);
  state_->acceptor.open(endpoint.protocol());
  state_->acceptor.set_option(tcp::acceptor::reuse_address(true));
  state_->acceptor.bind(endpoint);
  state_->acceptor.listen();
  state_->door.port = state_->acceptor.local_endpoint().port();
  state_->door.host = address.is_unspecified() ? asio::ip::host_name() : address.to_string();
  asio::co_spawn(state_->io, state_->accept(), asio::detached);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    ::sigaction(signal, nullptr, &before);
    if (signal != SIGHUP || before.sa_handler != SIG_IGN) state_->signals.add(signal);  // stays ignored with nohup
  }
  state_->signals.async_wait([this](const error_code& error, int) {
    if (!error) state_->io.stop();
  });
}

Server::~Server() = default;

std::string Server::address() const { return state_->door.address(); }

void Server::run() { state_->io.run(); }

void Server::send(Page page, const Packet& packet) {
  asio::post(state_->io, [this, page, packet] {
    for (const auto& [number, client] : state_->clients) {
      if (page == kAllPages || page == number) state_->put(*client, packet);
    }
  });
}

void Server::serve(int descriptor) {
  tcp::socket socket(state_->io);
  socket.assign(tcp::v4(), descriptor);
  state_->serve(std::move(socket));
}

std::size_t Server::connections() const { return state_->guests.size(); }

}  // namespace gicube::samples::view
