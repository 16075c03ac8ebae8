#include "view/server.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <deque>
#include <fstream>
#include <map>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include "gicube/scene/error.h"
#include "scene/common/checks.h"
#include "view/page_files.h"
#include "view/protocol.h"

namespace gicube::samples::view {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::awaitable;
using asio::ip::tcp;
using boost::system::error_code;
using HttpRequest = http::request<http::empty_body>;
using Parser = http::request_parser<http::empty_body>;

constexpr std::size_t kHeaderBytes = 8192;  // chosen: browsers' are below 2 KiB
constexpr std::size_t kMaxOut = 256;       // chosen: packets that wait for a page, beyond which it is too slow and left
constexpr std::chrono::seconds kIdle{60};  // chosen: between requests of one connection
constexpr std::chrono::milliseconds kAcceptRetry{100};  // chosen: until descriptors may be free again

auto into(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

// An answer that is not a page's file; its text is one line.
struct Refusal {
  http::status status;
  std::string text;
};

struct Target {
  std::string path;
  std::map<std::string, std::string> query;
};

std::string percent_decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    unsigned value = 0;
    for (std::size_t digit = 1; digit <= 2; ++digit) {
      const char c = i + digit < text.size() ? text[i + digit] : '\0';
      const std::size_t place = std::string_view("0123456789abcdefABCDEF").find(c);
      if (c == '\0' || place == std::string_view::npos)
        throw Refusal{http::status::bad_request, "a % without two digits"};
      value = 16 * value + static_cast<unsigned>(place < 16 ? place : place - 6);
    }
    out += static_cast<char>(value);
    i += 2;
  }
  return out;
}

Target target_of(std::string_view text) {
  Target target;
  const std::size_t query = text.find('?');
  target.path = percent_decoded(text.substr(0, query));
  while (query != std::string_view::npos && !text.empty()) {
    text.remove_prefix(std::min(text.find_first_of("?&"), text.size() - 1) + 1);
    const std::string_view part = text.substr(0, text.find('&'));
    const std::size_t equals = part.find('=');
    if (equals != std::string_view::npos)
      target.query.emplace(percent_decoded(part.substr(0, equals)), percent_decoded(part.substr(equals + 1)));
    if (part.size() == text.size()) break;
  }
  return target;
}

std::string_view view_of(beast::string_view text) { return {text.data(), text.size()}; }

}  // namespace

struct Server::State {
  struct Client {
    std::deque<Packet> out;
    asio::steady_timer wake;
    bool is_gone = false;
    explicit Client(asio::io_context& io) : wake(io, asio::steady_timer::time_point::max()) {}
  };
  using Stream = beast::tcp_stream;
  using Socket = websocket::stream<beast::tcp_stream>;

  Pages pages;
  std::string token;
  std::size_t connections = 0;  // outlives io, whose end is theirs
  asio::io_context io{1};
  tcp::acceptor acceptor{io};
  asio::signal_set signals{io};
  std::uint16_t port = 0;
  std::map<Page, std::shared_ptr<Client>> clients;
  Page last_page = kAllPages;
  std::map<std::string, std::uint64_t> posted;  // bytes

  void check(const HttpRequest& request, bool changes) const;
  void check_token(const Target& target) const;
  awaitable<void> accept();
  awaitable<void> connection(tcp::socket socket);
  awaitable<bool> answer(Stream& stream, beast::flat_buffer& buffer, Parser& parser);
  awaitable<void> take_file(Stream& stream, beast::flat_buffer& buffer, Parser& parser, const std::string& name);
  awaitable<bool> reply(Stream& stream, const HttpRequest& request, http::status status, std::string_view type,
                        std::string body, const std::string& attachment = {});
  awaitable<void> page(Stream stream, HttpRequest request);
  awaitable<void> write_out(Socket& socket, std::shared_ptr<Client> client, std::shared_ptr<bool> ended);
  void put(Client& client, const Packet& packet);
};

// Names of this machine that only it has: a foreign page whose name was made to mean this address says another Host.
void Server::State::check(const HttpRequest& request, bool changes) const {
  const auto host = view_of(request[http::field::host]);
  const std::string suffix = ':' + std::to_string(port);
  if (host != "127.0.0.1" + suffix && host != "localhost" + suffix)
    throw Refusal{http::status::forbidden, "Host: expected 127.0.0.1" + suffix};
  const auto origin = view_of(request[http::field::origin]);
  if (origin.empty() && !changes) return;
  if (origin != "http://" + std::string(host))
    throw Refusal{http::status::forbidden, "Origin: expected this page's own"};
}

void Server::State::check_token(const Target& target) const {
  const auto given = target.query.find("token");
  if (given == target.query.end() || !same_secret(given->second, token))
    throw Refusal{http::status::forbidden, "token: expected that of the address that gicube-view has printed"};
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
    asio::co_spawn(io, connection(std::move(socket)), asio::detached);
  }
}

awaitable<void> Server::State::connection(tcp::socket socket) {
  struct Count {
    std::size_t& count;
    explicit Count(std::size_t& all) : count(all) { ++count; }
    ~Count() { --count; }
    Count(const Count&) = delete;
    Count& operator=(const Count&) = delete;
  } const counted(connections);
  Stream stream(std::move(socket));
  error_code error;
  stream.socket().set_option(tcp::no_delay(true), error);
  try {
    beast::flat_buffer buffer(2 * kHeaderBytes);
    for (bool goes_on = true; goes_on;) {
      Parser parser;
      parser.header_limit(kHeaderBytes);
      parser.body_limit(kMaxFileBytes);
      stream.expires_after(buffer.size() > 0 ? std::chrono::seconds(kRequestTime) : kIdle);
      co_await http::async_read_header(stream, buffer, parser, into(error));
      if (error == http::error::header_limit) {
        co_await reply(stream, {}, http::status::request_header_fields_too_large, "text/plain", "too long a header\n");
      }
      if (error) break;
      goes_on = co_await answer(stream, buffer, parser);
    }
  } catch (const std::exception&) {
    // The other side has gone, or took too long.
  }
  stream.socket().shutdown(tcp::socket::shutdown_both, error);
}

// Whether the connection may have another request.
awaitable<bool> Server::State::answer(Stream& stream, beast::flat_buffer& buffer, Parser& parser) {
  const HttpRequest& request = parser.get();
  std::optional<Refusal> refusal;
  std::optional<Viewer::Download> found;
  bool is_page = false, is_file = false;
  try {
    if (connections > kMaxConnections) throw Refusal{http::status::service_unavailable, "too many connections"};
    const bool is_get = request.method() == http::verb::get;
    const Target target = target_of(view_of(request.target()));
    is_page = is_get && target.path == "/socket";
    is_file = request.method() == http::verb::post && target.path == "/file";
    check(request, is_page || is_file);
    if (is_get && parser.content_length_remaining().value_or(0) > 0)
      throw Refusal{http::status::bad_request, "a body: expected none"};
    if (parser.chunked() && is_get) throw Refusal{http::status::bad_request, "a body: expected none"};
    if (is_page || is_file || target.path == "/" || target.path == "/download") check_token(target);
    if (is_file) {
      const auto name = target.query.find("name");
      if (name == target.query.end() || !is_file_name(name->second))
        throw Refusal{http::status::bad_request, "name: expected a file's name, without folders"};
      co_await take_file(stream, buffer, parser, name->second);
      co_return co_await reply(stream, request, http::status::no_content, "text/plain", "");
    }
    if (!is_get) throw Refusal{http::status::bad_request, "expected GET, or POST /file"};
    if (is_page && !websocket::is_upgrade(request)) throw Refusal{http::status::bad_request, "expected a WebSocket"};
    if (!is_page && target.path == "/download") {
      const auto asked = [&target](const char* name) {
        const auto value = target.query.find(name);
        return value == target.query.end() ? std::string() : value->second;
      };
      found = pages.download(asked("what"), parse_number<std::uint64_t>(asked("number")).value_or(0));
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
    co_return false;
  }
  if (is_page) {
    HttpRequest upgrade = request;
    co_await page(std::move(stream), std::move(upgrade));
    co_return false;
  }
  co_return co_await reply(stream, request, http::status::ok, found->type, std::move(found->bytes), found->name);
}

awaitable<void> Server::State::take_file(Stream& stream, beast::flat_buffer& buffer, Parser& head,
                                         const std::string& name) {
  http::request_parser<http::buffer_body> parser(std::move(head));
  std::uint64_t others = 0;
  for (const auto& [other, bytes] : posted) others += other == name ? 0 : bytes;
  const std::uint64_t left = kMaxFileBytes - std::min(kMaxFileBytes, others);
  const Refusal too_large{http::status::payload_too_large,
                          fmt::format("a file: expected at most {} bytes with all that were posted", kMaxFileBytes)};
  if (parser.content_length().value_or(0) > left) throw too_large;
  if (view_of(parser.get()[http::field::expect]) == "100-continue") {
    http::response<http::empty_body> go_on(http::status::continue_, 11);
    co_await http::async_write(stream, go_on, asio::use_awaitable);
  }
  // Whole, or not at all: what had this name stays until then.
  const std::filesystem::path part = pages.folder / fmt::format(".part-{}", reinterpret_cast<std::uintptr_t>(&stream));
  struct Removed {
    const std::filesystem::path& path;
    ~Removed() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  } const removed{part};
  std::ofstream file(part, std::ios::binary | std::ios::trunc);
  std::vector<char> bytes(std::size_t{1} << 18);
  std::uint64_t taken = 0;
  while (!parser.is_done()) {
    parser.get().body().data = bytes.data();
    parser.get().body().size = bytes.size();
    stream.expires_after(kRequestTime);
    error_code error;
    co_await http::async_read(stream, buffer, parser, into(error));
    if (error && error != http::error::need_buffer) throw boost::system::system_error(error);
    const std::size_t count = bytes.size() - parser.get().body().size;
    taken += count;
    if (taken > left) throw too_large;
    file.write(bytes.data(), static_cast<std::streamsize>(count));
  }
  file.close();
  if (!file) throw Refusal{http::status::insufficient_storage, "a file: expected a disk with room for it"};
  std::filesystem::rename(part, pages.folder / name);
  posted[name] = taken;
}

awaitable<bool> Server::State::reply(Stream& stream, const HttpRequest& request, http::status status,
                                     std::string_view type, std::string body, const std::string& attachment) {
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
  stream.expires_after(kIdle);
  co_await http::async_write(stream, response, asio::use_awaitable);
  co_return goes_on;
}

awaitable<void> Server::State::page(Stream stream, HttpRequest request) {
  stream.expires_never();  // the WebSocket has limits of its own
  Socket socket(std::move(stream));
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
  client->wake.cancel();
  if (!is_fault) beast::get_lowest_layer(socket).close();
  asio::steady_timer pause(io);
  constexpr int kPatience = 1000;  // chosen: milliseconds for what is being written, before the reason is told
  for (int i = 0; !*ended; ++i) {  // it uses the socket
    if (i == kPatience) beast::get_lowest_layer(socket).close();
    pause.expires_after(std::chrono::milliseconds(1));
    co_await pause.async_wait(into(error));
  }
  if (is_fault) co_await socket.async_close(reason, into(error));
}

awaitable<void> Server::State::write_out(Socket& socket, std::shared_ptr<Client> client, std::shared_ptr<bool> ended) {
  error_code error;
  while (!client->is_gone) {
    if (client->out.empty()) {
      co_await client->wake.async_wait(into(error));
      continue;
    }
    const Packet packet = std::move(client->out.front());
    client->out.pop_front();
    socket.binary(packet.binary);
    co_await socket.async_write(asio::buffer(*packet.bytes), into(error));
    if (error) break;
  }
  *ended = true;
}

void Server::State::put(Client& client, const Packet& packet) {
  if (packet.droppable) {
    std::erase_if(client.out, [&](const Packet& other) { return other.droppable && other.binary == packet.binary; });
  }
  client.out.push_back(packet);
  if (client.out.size() > kMaxOut) client.is_gone = true;
  client.wake.cancel();
}

Server::Server(Pages pages, std::string token) : state_(std::make_unique<State>()) {
  state_->pages = std::move(pages);
  state_->token = std::move(token);
}

Server::Server(Pages pages, std::uint16_t port, std::string token) : Server(std::move(pages), std::move(token)) {
  const tcp::endpoint endpoint(asio::ip::address_v4::loopback(), port);
  state_->acceptor.open(endpoint.protocol());
  state_->acceptor.set_option(tcp::acceptor::reuse_address(true));
  state_->acceptor.bind(endpoint);
  state_->acceptor.listen();
  state_->port = state_->acceptor.local_endpoint().port();
  asio::co_spawn(state_->io, state_->accept(), asio::detached);
}

Server::~Server() = default;

std::uint16_t Server::port() const { return state_->port; }

std::string Server::address() const { return fmt::format("http://127.0.0.1:{}/?token={}", port(), state_->token); }

void Server::run() {
  if (state_->port != 0) {
    state_->signals.add(SIGINT);
    state_->signals.add(SIGTERM);
    state_->signals.async_wait([this](const error_code& error, int) {
      if (!error) state_->io.stop();
    });
  }
  state_->io.run();
}

void Server::stop() { state_->io.stop(); }

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
  asio::co_spawn(state_->io, state_->connection(std::move(socket)), asio::detached);
}

std::size_t Server::connections() const { return state_->connections; }

}  // namespace gicube::samples::view
