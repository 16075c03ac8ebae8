// Asio helpers for the coroutines of the sockets.
#pragma once

#include <algorithm>
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

// Sleeps for `duration`, or until `ends()` returns true.
template <typename Executor, typename Ends>
awaitable<void> sleep_unless(Executor executor, std::chrono::steady_clock::duration duration, Ends ends) {
  using std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kLook{50};  // chosen: latency for detecting the end
  asio::steady_timer timer(executor);
  for (const auto end = steady_clock::now() + duration; !ends() && steady_clock::now() < end;) {
    co_await sleep(timer, std::min<steady_clock::duration>(end - steady_clock::now(), kLook));
  }
}

}  // namespace gicube::emu
