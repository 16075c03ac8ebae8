// A program for mpirun: what the exchange between ranks must keep. Prints what went wrong, and ends with exit code 1
// then. Usage: mpi_ranks exchange BYTES | large BYTES | abort
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "gicube/error.h"
#include "gicube/mpi.h"

namespace {

using Messages = std::vector<std::vector<std::uint8_t>>;

// What rank `from` sends to `to` in a round: any rank can say it.
std::vector<std::uint8_t> message(int round, int from, int to) {
  std::seed_seq seed{round, from, to};
  std::mt19937 random(seed);
  const unsigned kind = random() % 4;
  std::vector<std::uint8_t> bytes(kind == 0 ? 0 : kind == 1 ? 32 : random() % 20000);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  return bytes;
}

void expect(bool is_so, const std::string& what) {
  if (is_so) return;
  throw std::runtime_error(what);
}

// Rounds follow each other at once, and ranks come to them at different times.
void random_rounds(gicube::RayExchange& ranks, int rounds) {
  const int me = ranks.rank();
  for (int round = 0; round < rounds; ++round) {
    if ((round + me) % 16 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    Messages to;
    for (int r = 0; r < ranks.ranks(); ++r) to.push_back(message(round, me, r));
    const Messages from = ranks.exchange(std::move(to));
    expect(from.size() == static_cast<std::size_t>(ranks.ranks()), "too few messages");
    for (int r = 0; r < ranks.ranks(); ++r) {
      expect(from[static_cast<std::size_t>(r)] == message(round, r, me),
             fmt::format("rank {}, round {}: rank {}'s message is not what it sent", me, round, r));
    }
    if (round % 10 == 0) {
      const auto own = static_cast<std::uint64_t>(me + 1) << 40;
      const auto count = static_cast<std::uint64_t>(ranks.ranks());
      expect(ranks.sum(own) == (count * (count + 1) / 2) << 40, "a sum is wrong");
    }
  }
}

// All wait for one until they look seldom; the first that sees the round's end sends at once what another must not take
// for a message of the round before.
void close_rounds(gicube::RayExchange& ranks, int rounds) {
  const int me = ranks.rank();
  for (int round = 0; round < rounds; ++round) {
    if (round % 2 == 0 && round / 2 % ranks.ranks() == me) std::this_thread::sleep_for(std::chrono::milliseconds(8));
    const Messages to(static_cast<std::size_t>(ranks.ranks()), {static_cast<std::uint8_t>(round)});
    expect(ranks.exchange(to) == to, fmt::format("rank {}: round {} has messages of another", me, round));
  }
}

// Each sends a message of so many bytes to the next.
void large(gicube::RayExchange& ranks, std::size_t bytes) {
  Messages to(static_cast<std::size_t>(ranks.ranks()));
  const int next = (ranks.rank() + 1) % ranks.ranks();
  auto& sent = to[static_cast<std::size_t>(next)];
  sent.resize(bytes);
  for (std::size_t i = 0; i < bytes; i += 4093) sent[i] = static_cast<std::uint8_t>(i + static_cast<std::size_t>(next));
  const Messages from = ranks.exchange(std::move(to));
  const int before = (ranks.rank() + ranks.ranks() - 1) % ranks.ranks();
  const auto& got = from[static_cast<std::size_t>(before)];
  expect(got.size() == bytes, fmt::format("{} bytes came of {}", got.size(), bytes));
  for (std::size_t i = 0; i < bytes; i += 4093) {
    expect(got[i] == static_cast<std::uint8_t>(i + static_cast<std::size_t>(ranks.rank())),
           fmt::format("byte {} differs", i));
  }
}

std::string refused(const auto& call) {
  try {
    call();
  } catch (const gicube::Error& error) {
    return error.what();
  }
  return "";
}

void check_errors(gicube::RayExchange& ranks) {
  expect(refused([&] { ranks.exchange({}); }).starts_with("to: expected "), "too few messages were sent");
  expect(refused([] { gicube::MpiExchange::open(0); }).starts_with("max_message: expected 1 to "),
         "no bytes at a time");
  // MPI's own error, with its text: no communicator has this handle.
  const std::string text = refused([] { gicube::MpiExchange::of(123456); });
  expect(text.starts_with("MPI_Comm_dup: ") && text.size() > 20, "an unknown communicator: " + text);
}

void run(const std::string& what, std::size_t bytes) {
  const auto ranks = gicube::MpiExchange::open();
  if (what == "exchange") {
    random_rounds(*ranks, 100);
    close_rounds(*ranks, 50);
    large(*ranks, bytes);
    check_errors(*ranks);
    const auto in_parts = gicube::MpiExchange::open(1000);
    random_rounds(*in_parts, 30);
  }
  if (what == "large") large(*ranks, bytes);
  if (what == "abort" && ranks->rank() == ranks->ranks() - 1) ranks->abort(3);
  if (what == "abort") ranks->sum(0);  // waits for that one
  if (ranks->rank() == 0) fmt::print("{}: {} ranks are right\n", what, ranks->ranks());
}

}  // namespace

int main(int argc, char** argv) {
  try {
    run(argc > 1 ? argv[1] : "", argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 0);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "mpi_ranks: {}\n", error.what());
    return 1;
  }
}
