#include "firmware/routines/plug_in_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <system_error>
#include <thread>
#include <vector>

#include "words/finally.h"

extern char** environ;

namespace gicube::emu {

namespace {

// Installed and built beside the programs, as seen from theirs; so a tree may be moved.
constexpr const char* kProgram = "../libexec/gicube/gicube-bsdf-host";

constexpr std::chrono::seconds kPatience{
    5};  // chosen: a thousand times what the end of a process takes on a busy machine

// How often a side looks before it sleeps, while each has a processor of its own. chosen: tens of microseconds, in which most rays come
// to their next call.
constexpr unsigned kSpins = 1000;

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

// Beyond those that the new process has: no copy of one overwrites another.
int high(int fd) {
  const int copy = ::fcntl(fd, F_DUPFD_CLOEXEC, kMemoryDescriptor + 1);
  const int error = errno;
  ::close(fd);
  if (copy < 0) fail(error, "a descriptor");
  return copy;
}

// What decides how the dynamic linker and sanitizers work, and no more: the rest may hold secrets.
std::vector<char*> environment() {
  std::vector<char*> out;
  for (char** each = environ; *each != nullptr; ++each) {
    const std::string name(*each, ::strcspn(*each, "="));
    if (name == "LD_LIBRARY_PATH" || name.ends_with("SAN_OPTIONS")) out.push_back(*each);
  }
  out.push_back(nullptr);
  return out;
}

// Without what the thread blocks and ignores, and in a group of its own: a terminal's signals are for the board.
pid_t start(const std::string& program, const std::string& file, bool is_boxed, int orders, int memory) {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawnattr_init(&attributes);
  const Finally freed{[&] {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }};
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&actions, standard, "/dev/null", O_RDWR, 0);
  }
  ::posix_spawn_file_actions_adddup2(&actions, orders, kOrdersDescriptor);
  ::posix_spawn_file_actions_adddup2(&actions, memory, kMemoryDescriptor);
  ::posix_spawn_file_actions_addclosefrom_np(&actions, kMemoryDescriptor + 1);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  std::string name = "gicube-bsdf-host", argument = file, box = is_boxed ? kBoxedWord : kUnboxedWord;
  char* const arguments[]{name.data(), argument.data(), box.data(), nullptr};
  pid_t process = 0;
  const int error = ::posix_spawn(&process, program.c_str(), &actions, &attributes, arguments, environment().data());
  if (error != 0) fail(error, program);
  return process;
}

// Of the whole process; nothing once it is gone.
std::chrono::nanoseconds cpu_time(pid_t process) {
  clockid_t clock{};
  timespec used{};
  if (process <= 0 || ::clock_getcpuclockid(process, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return {};
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

std::string end_of(int status) {
  if (status == CallSlot::kNoProcess) return "no process for its call could be started";
  if (WIFSIGNALED(status)) {
    const char* const name = ::sigdescr_np(WTERMSIG(status));
    return "its process was ended by signal " + std::to_string(WTERMSIG(status)) +
           (name != nullptr ? " (" + std::string(name) + ')' : std::string());
  }
  return "it ended its process, with exit code " + std::to_string(WEXITSTATUS(status));
}

void tell(const ScatterEvent& event, CallSlot::Event& to) {
  gicube_bsdf_event out{};
  out.size = sizeof out;
  out.tag = event.tag;
  std::copy(event.position.begin(), event.position.end(), out.position);
  std::copy(event.direction.begin(), event.direction.end(), out.direction);
  std::copy(event.normal.begin(), event.normal.end(), out.normal);
  out.opacity = event.opacity;
  out.density = event.density;
  std::copy(event.random.begin(), event.random.end(), out.random);
  out.lighting = event.lighting ? 1 : 0;
  out.generation = event.generation;
  out.parameter_count = static_cast<std::uint32_t>(event.parameters.size());
  to.event = out;
  std::copy(event.parameters.begin(), event.parameters.end(), to.parameters);
}

ScatterAnswer answer_of(gicube_bsdf_answer answer) {
  return {{answer.direction[0], answer.direction[1], answer.direction[2]}, answer.passes, answer.cycles};
}

std::string stuck() { return "did not return within " + std::to_string(kCpuLimit.count()) + " ms of processor time"; }

}  // namespace

std::string printable(const char* text, std::size_t max_length) {
  std::string out(text, ::strnlen(text, max_length));
  std::replace_if(
      out.begin(), out.end(), [](char c) { return c < 0x20 || c > 0x7E; }, '?');
  return out;
}

// A slot that is this thread's for a call. A thread takes the one that it had, if it can: the processor still has its memory.
class PlugInProcess::Claim {
 public:
  explicit Claim(PlugInProcess& of) : of_(of) {
    thread_local std::size_t last = 0;
    for (std::size_t tried = 0; of_.slot_states_[last].is_taken.exchange(true); last = (last + 1) % kMaxCalls) {
      if (++tried % kMaxCalls == 0) std::this_thread::yield();
    }
    index_ = last;
  }
  ~Claim() {
    if (!is_lost_) of_.slot_states_[index_].is_taken = false;
  }
  Claim(const Claim&) = delete;
  Claim& operator=(const Claim&) = delete;

  std::size_t index() const { return index_; }
  CallSlot& slot() const { return of_.memory_->slots[index_]; }
  void lose() { is_lost_ = true; }  // nobody may use it any more: a process that did not end might

 private:
  PlugInProcess& of_;
  std::size_t index_;
  bool is_lost_ = false;
};

PlugInProcess::PlugInProcess(const std::string& file, bool is_boxed) {
  try {
    load(file, is_boxed);
  } catch (const std::system_error& error) {
    stop();
    throw PlugInFault(file + ": no process for it: " + error.what());
  } catch (...) {
    stop();
    throw;
  }
}

PlugInProcess::~PlugInProcess() { stop(); }

void PlugInProcess::load(const std::string& file, bool is_boxed) {
  // Its size is sealed, or a process that has it could have this one read beyond its end.
  const int memory = high(::memfd_create("gicube-bsdf", MFD_CLOEXEC | MFD_ALLOW_SEALING));
  const Finally closed{[memory] { ::close(memory); }};
  if (::ftruncate(memory, sizeof(CallMemory)) != 0 ||
      ::fcntl(memory, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) {
    fail(errno, "memory");
  }
  void* const mapped = ::mmap(nullptr, sizeof(CallMemory), PROT_READ | PROT_WRITE, MAP_SHARED, memory, 0);
  if (mapped == MAP_FAILED) fail(errno, "memory");
  memory_ = static_cast<CallMemory*>(mapped);

  int ends[2];
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) fail(errno, "socket");
  orders_ = ends[0];
  Turn& turn = memory_->loading.turn;
  turn.give(Party::kPlugIn);
  {
    const int its = high(ends[1]);
    const Finally its_closed{[its] { ::close(its); }};  // so that this end says when the process has gone
    const std::filesystem::path own = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    // A name without a slash would be looked for in the system's library folders.
    process_ = start(own / kProgram, std::filesystem::absolute(file), is_boxed, its, memory);
  }
  Patience patience;
  const Waited waited = wait(turn, process_, 0, patience);
  if (waited == Waited::kStuck) throw PlugInFault(file + ": its loading or gicube_bsdf_describe() " + stuck());
  if (waited != Waited::kAnswered) {
    int status = CallSlot::kNoProcess;
    ::kill(process_, SIGKILL);  // if it has not ended by itself
    ::waitpid(process_, &status, 0);
    process_ = 0;
    throw PlugInFault(file + ": loading it: " + end_of(status));
  }
  const std::string fault = printable(memory_->loading.fault, kMaxText);
  if (!fault.empty()) throw PlugInFault(fault);
  description_ = memory_->loading.description;
}

// Where the board's process may neither end nor wait for others (its box), the closed socket ends it all the same.
void PlugInProcess::stop() {
  if (process_ != 0) {
    ::shutdown(orders_, SHUT_WR);
    pollfd gone{orders_, 0, 0};
    if (memory_->loading.turn.now() != Party::kBoard ||
        ::poll(&gone, 1, static_cast<int>(std::chrono::milliseconds(kPatience).count())) == 0) {
      ::kill(process_, SIGKILL);
    }
    ::waitpid(process_, nullptr, 0);
  }
  if (orders_ >= 0) ::close(orders_);
  if (memory_ != nullptr) ::munmap(memory_, sizeof(CallMemory));
}

bool PlugInProcess::has_gone() const {
  pollfd events{orders_, 0, 0};
  return ::poll(&events, 1, 0) > 0 && (events.revents & (POLLHUP | POLLERR)) != 0;
}

bool PlugInProcess::order(SlotOrder::Kind kind, std::size_t slot) const {
  const SlotOrder order{kind, static_cast<std::uint32_t>(slot)};
  return ::send(orders_, &order, sizeof order, MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(sizeof order);
}

PlugInProcess::Waited PlugInProcess::wait(Turn& turn, const std::int32_t& process, unsigned max_spins,
                                          Patience& patience, std::uint32_t steps) const {
  using std::chrono::steady_clock;
  std::optional<std::chrono::nanoseconds> used;  // at the first tick
  int ticks = 0;
  std::uint32_t at_step = 0;
  for (auto tick = steady_clock::now() + kTick; !turn.wait_for(Party::kPlugIn, max_spins, patience, kTick);) {
    if (has_gone() && turn.now() == Party::kPlugIn) return Waited::kLost;
    if (steady_clock::now() < tick) continue;  // woken for nothing
    tick += kTick;
    const auto now = cpu_time(process);
    if (!used || (steps > 0 && turn.steps() != at_step)) {
      used = now;
      ticks = 0;
      at_step = turn.steps();
      --steps;
    }
    if (++ticks > kTicksLimit || now - *used >= kCpuLimit) return Waited::kStuck;
  }
  return turn.now() == Party::kBoard ? Waited::kAnswered : Waited::kEnded;
}

std::optional<std::string> PlugInProcess::call(Claim& claim, std::uint32_t count) {
  CallSlot& slot = claim.slot();
  slot.count = count;
  const char* const kLost = "its process was ended; it is not called again before the board process is started anew";
  static const unsigned processors = std::thread::hardware_concurrency();
  const auto number = static_cast<unsigned>(claim.index() + 1);
  if (number > at_once_) at_once_ = number;  // of two such threads either may be the last: a hint
  const unsigned spins = 2 * at_once_ <= processors ? kSpins : 0;
  slot.spins = spins;
  if (!slot.turn.give(Party::kBoard, Party::kPlugIn)) {
    slot.turn.give(Party::kPlugIn);
    if (!order(SlotOrder::Kind::kBegin, claim.index())) {
      slot.turn.give(Party::kNobody);
      return kLost;
    }
  }
  switch (wait(slot.turn, slot.process, spins, slot_states_[claim.index()].patience, count)) {
    case Waited::kAnswered: return std::nullopt;
    case Waited::kEnded: return end_of(slot.wait_status);
    case Waited::kLost: slot.turn.give(Party::kNobody); return kLost;
    case Waited::kStuck: break;
  }
  order(SlotOrder::Kind::kEnd, claim.index());
  const auto end = std::chrono::steady_clock::now() + kPatience;
  while (slot.turn.now() != Party::kNobody && !has_gone()) {
    if (std::chrono::steady_clock::now() > end) {
      claim.lose();
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return stuck();
}

std::optional<std::string> PlugInProcess::scatter(std::span<const ScatterEvent> events,
                                                  std::span<ScatterAnswer> answers) {
  Claim claim(*this);
  CallSlot& slot = claim.slot();
  slot.call = CallKind::kScatter;
  const auto count = static_cast<std::uint32_t>(answers.size());
  for (std::uint32_t i = 0; i < count; ++i) tell(events[i], slot.events[i]);
  if (auto fault = call(claim, count)) return fault;
  for (std::uint32_t i = 0; i < count; ++i) answers[i] = answer_of(slot.answers[i]);
  if (slot.outcome == Outcome::kReturned) return std::nullopt;
  const std::string text = printable(slot.text, kMaxText);
  return text.empty() ? "threw an exception" : "threw an exception: " + text;
}

std::optional<std::string> PlugInProcess::check(std::span<const float> parameters, int& verdict, std::string& text) {
  Claim claim(*this);
  CallSlot& slot = claim.slot();
  slot.call = CallKind::kCheck;
  slot.events[0].event.parameter_count = static_cast<std::uint32_t>(parameters.size());
  std::copy(parameters.begin(), parameters.end(), slot.events[0].parameters);
  if (auto fault = call(claim, 1)) return fault;
  if (slot.outcome != Outcome::kReturned) return "its parameter check threw an exception";
  verdict = slot.verdict;
  text = printable(slot.text, kMaxText);
  return std::nullopt;
}

}  // namespace gicube::emu
