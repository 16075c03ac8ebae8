// Asio helpers for the coroutines of the sockets.
#pragma once

#include <chrono>
#include <utility>  // Boost 1.74's awaitable.hpp uses std::exchange without it

#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>

namespace gicube::emu {

namespace asio = boost::asio;
using asio::awaitable;
using boost::system::error_code;

// Makes an operation return its error instead of throwing it.
inline auto into(error_code& error) { return asio::redirect_error(asio::use_awaitable, error); }

// Ends early if the timer is cancelled.
inline awaitable<void> sleep(asio::steady_timer& timer, std::chrono::steady_clock::duration duration) {
  timer.expires_after(duration);
  error_code ignored;
  co_await timer.async_wait(into(ignored));
}

}  // namespace gicube::emu
