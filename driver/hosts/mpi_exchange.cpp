#define OMPI_SKIP_MPICXX 1  // of MPI its C interface alone
#define MPICH_SKIP_MPICXX 1
#include "gicube/mpi.h"

#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "gicube/error.h"

// MPI's constants cast through void in Open MPI. NOLINTBEGIN(bugprone-casting-through-void)
namespace gicube {
namespace {

void expect_success(int code, const char* what) {
  if (code == MPI_SUCCESS) return;
  std::string text(MPI_MAX_ERROR_STRING, '\0');
  int length = 0;
  MPI_Error_string(code, text.data(), &length);
  text.resize(static_cast<std::size_t>(length));
  throw Error(std::string(what) + ": " + text);
}

// Between looks for messages: none at first, then longer and longer ones.
class Patience {
 public:
  void reset() { looks_ = 0; }
  void wait() {
    constexpr int kAtOnce = 1000,
                  kMost = 50;  // chosen: looks, about 0.1 ms; microseconds, since large messages go on at looks only
    if (++looks_ <= kAtOnce) return;
    std::this_thread::sleep_for(std::chrono::microseconds(std::min(looks_ - kAtOnce, kMost)));
  }

 private:
  int looks_ = 0;
};

class Exchange : public MpiExchange {
 public:
  Exchange(MPI_Comm communicator, bool initialised_here, std::size_t max_message)
      : initialised_here_(initialised_here), max_message_(max_message), exceptions_(std::uncaught_exceptions()) {
    expect_success(MPI_Comm_dup(communicator, &communicator_), "MPI_Comm_dup");
    MPI_Comm_set_errhandler(communicator_, MPI_ERRORS_RETURN);
    expect_success(MPI_Comm_rank(communicator_, &rank_), "MPI_Comm_rank");
    expect_success(MPI_Comm_size(communicator_, &ranks_), "MPI_Comm_size");
  }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;
  ~Exchange() override {
    if (std::uncaught_exceptions() > exceptions_) return;
    MPI_Comm_free(&communicator_);
    if (initialised_here_) MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int ranks() const override { return ranks_; }
  std::vector<std::vector<std::uint8_t>> exchange(std::vector<std::vector<std::uint8_t>> to) override;
  std::uint64_t sum(std::uint64_t value) override {
    std::uint64_t all = 0;
    MPI_Request request = MPI_REQUEST_NULL;
    expect_success(MPI_Iallreduce(&value, &all, 1, MPI_UINT64_T, MPI_SUM, communicator_, &request), "MPI_Iallreduce");
    wait(request);
    return all;
  }
  std::uint64_t bytes_sent() const override { return bytes_sent_; }
  [[noreturn]] void abort(int code) override {
    MPI_Abort(communicator_, code);
    std::terminate();
  }

 private:
  void wait(MPI_Request& request) const {
    Patience patience;
    for (int done = 0; expect_success(MPI_Test(&request, &done, MPI_STATUS_IGNORE), "MPI_Test"), done == 0;)
      patience.wait();
  }
  std::vector<MPI_Request> send(const std::vector<std::vector<std::uint8_t>>& to, int tag) const;
  bool receive(std::vector<std::vector<std::uint8_t>>& from, int tag) const;

  MPI_Comm communicator_ = MPI_COMM_NULL;
  bool initialised_here_;
  std::size_t max_message_;
  int exceptions_;
  int rank_ = 0, ranks_ = 1;
  std::uint64_t bytes_sent_ = 0;
  // Tags tell a round's messages from the next one's: a rank may be through the barrier, and send on, while another has
  // yet to see that it is. Nobody is two rounds ahead.
  int round_ = 0;
};

// Begins to send, in parts of at most max_message_ bytes; those for one rank arrive in their order.
std::vector<MPI_Request> Exchange::send(const std::vector<std::vector<std::uint8_t>>& to, int tag) const {
  std::vector<MPI_Request> sends;
  for (int r = 0; r < ranks_; ++r) {
    const auto& message = to[static_cast<std::size_t>(r)];
    for (std::size_t at = 0; r != rank_ && at < message.size(); at += max_message_) {
      const auto bytes = static_cast<int>(std::min(max_message_, message.size() - at));
      expect_success(MPI_Issend(message.data() + at, bytes, MPI_BYTE, r, tag, communicator_, &sends.emplace_back()),
                     "MPI_Issend");
    }
  }
  return sends;
}

// A message that is there, if there is one.
bool Exchange::receive(std::vector<std::vector<std::uint8_t>>& from, int tag) const {
  MPI_Message message = MPI_MESSAGE_NULL;
  MPI_Status status;
  int there = 0, bytes = 0;
  expect_success(MPI_Improbe(MPI_ANY_SOURCE, tag, communicator_, &there, &message, &status), "MPI_Improbe");
  if (there == 0) return false;
  expect_success(MPI_Get_count(&status, MPI_BYTE, &bytes), "MPI_Get_count");
  auto& place = from[static_cast<std::size_t>(status.MPI_SOURCE)];
  const std::size_t at = place.size();
  place.resize(at + static_cast<std::size_t>(bytes));
  expect_success(MPI_Mrecv(place.data() + at, bytes, MPI_BYTE, &message, MPI_STATUS_IGNORE), "MPI_Mrecv");
  return true;
}

std::vector<std::vector<std::uint8_t>> Exchange::exchange(std::vector<std::vector<std::uint8_t>> to) {
  if (to.size() != static_cast<std::size_t>(ranks_)) {
    throw BadArgument("to", std::to_string(ranks_) + " messages, one per rank", std::to_string(to.size()));
  }
  std::vector<std::vector<std::uint8_t>> from(to.size());
  const int tag = round_;
  round_ ^= 1;
  std::vector<MPI_Request> sends = send(to, tag);
  for (std::size_t r = 0; r < to.size(); ++r) bytes_sent_ += r == static_cast<std::size_t>(rank_) ? 0 : to[r].size();
  MPI_Request barrier = MPI_REQUEST_NULL;
  bool in_barrier = false;
  Patience patience;
  for (int done = 0; done == 0;) {
    while (receive(from, tag)) patience.reset();
    if (in_barrier) {
      expect_success(MPI_Test(&barrier, &done, MPI_STATUS_IGNORE), "MPI_Ibarrier");
    } else {
      int sent = 0;
      expect_success(MPI_Testall(static_cast<int>(sends.size()), sends.data(), &sent, MPI_STATUSES_IGNORE),
                     "MPI_Issend");
      if (sent != 0) {
        expect_success(MPI_Ibarrier(communicator_, &barrier), "MPI_Ibarrier");
        in_barrier = true;
        continue;
      }
    }
    if (done == 0) patience.wait();
  }
  from[static_cast<std::size_t>(rank_)] = std::move(to[static_cast<std::size_t>(rank_)]);
  return from;
}

void check(std::size_t max_message) {
  if (max_message >= 1 && max_message <= MpiExchange::kMaxMessage) return;
  throw BadArgument("max_message", "1 to " + std::to_string(MpiExchange::kMaxMessage), std::to_string(max_message));
}

}  // namespace

std::unique_ptr<MpiExchange> MpiExchange::open(std::size_t max_message) {
  check(max_message);
  int initialised = 0, provided = 0;
  MPI_Initialized(&initialised);
  if (initialised == 0) {
    expect_success(MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &provided), "MPI_Init_thread");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
  }
  return std::make_unique<Exchange>(MPI_COMM_WORLD, initialised == 0, max_message);
}

std::unique_ptr<MpiExchange> MpiExchange::of(int communicator, std::size_t max_message) {
  check(max_message);
  return std::make_unique<Exchange>(MPI_Comm_f2c(communicator), false, max_message);
}

}  // namespace gicube
// NOLINTEND(bugprone-casting-through-void)

gicube::MpiExchange* gicube_mpi_open() { return gicube::MpiExchange::open().release(); }
