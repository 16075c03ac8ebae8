// What a process in the box can't do, and what it still can: tried in children, each of which enters it.
#include "box/box.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <future>

#include "server/audit.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

namespace fs = std::filesystem;
using Access = Box::Access;
using Part = Boxed::Part;

constexpr int kEnded = 128;  // and the signal that did it
constexpr int kNoBox = 127;
const std::string kOutside = "/etc/passwd";  // which every user may read

// What the work returns, done by a child.
int in_child(const std::function<int()>& work) {
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    ::_exit(work());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : kEnded + WTERMSIG(status);
}

int in_box(const Box& box, const std::function<int()>& attempt) {
  return in_child([&] { return enter_box(box).calls == Part::kInForce ? attempt() : kNoBox; });
}

int error_of(long result) { return result < 0 ? errno : 0; }
int try_to_open(const std::string& path, int flags = O_RDONLY) {
  return error_of(::open(path.c_str(), flags, S_IRUSR | S_IWUSR));
}
int try_to_make(const std::string& path) { return try_to_open(path, O_WRONLY | O_CREAT | O_EXCL); }

// The part of a box that a test is about: skipped where there is none, by what the box says.
class PartOfBox : public testing::Test {
 protected:
  void need(Part Boxed::*part) {
    std::string text(200, '\0');
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const int state = in_child([&] {
      const Boxed boxed = enter_box({});
      const ssize_t written = ::write(ends[1], boxed.text.data(), std::min(boxed.text.size(), text.size()));
      return written < 0 ? kNoBox : static_cast<int>(boxed.*part);
    });
    ::close(ends[1]);
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, ::read(ends[0], text.data(), text.size()))));
    ::close(ends[0]);
    if (state == static_cast<int>(Part::kMissing)) GTEST_SKIP() << text;
    ASSERT_EQ(state, static_cast<int>(Part::kInForce)) << text;
  }
};

class BoxOfCalls : public PartOfBox {
 protected:
  void SetUp() override { need(&Boxed::calls); }
};

class BoxOfFiles : public PartOfBox {
 protected:
  void SetUp() override { need(&Boxed::files); }

  const reference::TemporaryDirectory inside_, outside_;
};

TEST_F(BoxOfCalls, StartsNoProgramAndEndsWhoTries) {
  EXPECT_EQ(in_box({},
                   [] {
                     const char* const words[] = {"true", nullptr};
                     return error_of(::execv("/bin/true", const_cast<char* const*>(words)));
                   }),
            kEnded + SIGSYS);
}

TEST_F(BoxOfCalls, StartsNoProcess) {
  EXPECT_EQ(in_box({}, [] { return error_of(::fork()); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::syscall(SYS_clone3, nullptr, 0)); }), ENOSYS);
  EXPECT_EQ(in_box({},
                   [] {
                     const char* const words[] = {"true", nullptr};
                     pid_t started = 0;
                     return ::posix_spawn(&started, "/bin/true", nullptr, nullptr, const_cast<char* const*>(words),
                                          nullptr);
                   }),
            EPERM);
}

TEST_F(BoxOfCalls, EndsWhoReachesForOtherProcessesOrForTheKernel) {
  EXPECT_EQ(in_box({}, [] { return error_of(::ptrace(PTRACE_ATTACH, ::getppid(), nullptr, nullptr)); }),
            kEnded + SIGSYS);
  EXPECT_EQ(
      in_box({}, [] { return error_of(::syscall(SYS_process_vm_readv, ::getppid(), nullptr, 0, nullptr, 0, 0)); }),
      kEnded + SIGSYS);
  EXPECT_EQ(in_box({}, [] { return error_of(::syscall(SYS_bpf, 0, nullptr, 0)); }), kEnded + SIGSYS);
  EXPECT_EQ(in_box({}, [] { return error_of(::syscall(SYS_unshare, 0)); }), kEnded + SIGSYS);
}

TEST_F(BoxOfCalls, SignalsNoOtherProcess) {
  const pid_t test = ::getpid();
  EXPECT_EQ(in_box({}, [&] { return error_of(::kill(test, 0)); }), EPERM);
  EXPECT_EQ(in_box({}, [&] { return error_of(::tgkill(test, test, 0)); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::raise(SIGTERM)); }), kEnded + SIGTERM) << "but itself";
}

TEST_F(BoxOfCalls, MakesNoSocketAndConnectsNone) {
  for (const int family : {AF_UNIX, AF_INET, AF_NETLINK}) {
    EXPECT_EQ(in_box({}, [&] { return error_of(::socket(family, SOCK_DGRAM, 0)); }), EPERM) << family;
  }
  const int made_before = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
  EXPECT_EQ(in_box({}, [&] { return error_of(::connect(made_before, generic, sizeof address)); }), EPERM);
  EXPECT_EQ(in_box({}, [&] { return error_of(::bind(made_before, generic, sizeof address)); }), EPERM);
  EXPECT_EQ(in_box({}, [&] { return error_of(::listen(made_before, 1)); }), EPERM);
  ::close(made_before);
}

TEST_F(BoxOfCalls, TakesClientsOnlyIfItHasThem) {
  const int listening = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;  // the kernel gives it a name
  ASSERT_EQ(::bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address.sun_family), 0);
  ASSERT_EQ(::listen(listening, 1), 0);
  const auto take = [&] { return error_of(::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC)); };
  EXPECT_EQ(in_box({}, take), EAGAIN);
  EXPECT_EQ(in_box({.has_clients = false}, take), EPERM);
  ::close(listening);
}

TEST_F(BoxOfCalls, ExecutesNothingThatItWrites) {
  const std::size_t page = 4096;
  EXPECT_EQ(in_box({},
                   [&] {
                     void* const place =
                         ::mmap(nullptr, page, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
                     return place == MAP_FAILED ? errno : 0;
                   }),
            EPERM);
  EXPECT_EQ(in_box({},
                   [&] {
                     void* const place =
                         ::mmap(nullptr, page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
                     return place == MAP_FAILED ? kNoBox : error_of(::mprotect(place, page, PROT_READ | PROT_EXEC));
                   }),
            EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::syscall(SYS_memfd_create, "program", 0)); }), EPERM);
}

TEST_F(BoxOfCalls, OpensNothingWithoutAPlace) {
  EXPECT_EQ(in_box({}, [] { return try_to_open(kOutside); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::rename("a", "b")); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::unlink("a")); }), EPERM);
}

TEST_F(BoxOfCalls, ChangesNeitherModesNorOwnersNorItsUser) {
  EXPECT_EQ(in_box({}, [] { return error_of(::chmod(".", 0)); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::chown(".", 1, 1)); }), EPERM);
  EXPECT_EQ(in_box({}, [] { return error_of(::setuid(1)); }), EPERM);
}

TEST_F(BoxOfCalls, StillHasThreadsMemoryTimeAndRandomNumbers) {
  EXPECT_EQ(in_box({},
                   [] {
                     std::vector<std::future<std::size_t>> threads;
                     for (int i = 0; i < 4; ++i) {
                       threads.push_back(std::async(std::launch::async, [] {
                         std::this_thread::sleep_for(std::chrono::milliseconds(1));
                         return std::vector<char>(std::size_t{64} << 20, 'x').size();
                       }));
                     }
                     for (auto& each : threads) each.get();
                     return std::random_device()() == std::random_device()() ? 1 : 0;
                   }),
            0);
}

// The kernel takes both parts for one thread; the others have to follow.
TEST_F(BoxOfFiles, HoldsForThreadsThatRanBeforeAndForThoseThatFollow) {
  EXPECT_EQ(in_child([&] {
              int pipe[2];
              if (::pipe(pipe) != 0) return kNoBox;
              std::promise<void> boxed;
              const std::shared_future<void> is_boxed = boxed.get_future().share();
              std::vector<std::future<int>> threads;
              for (int i = 0; i < 8; ++i) {
                threads.push_back(std::async(std::launch::async, [is_boxed] {
                  is_boxed.wait();
                  const auto later = std::async(std::launch::async, try_to_open, kOutside, O_RDONLY).get();
                  return later == EACCES ? try_to_open(kOutside) : later;
                }));
              }
              threads.push_back(std::async(std::launch::async, [end = pipe[0]] {  // in a call that the box interrupts
                char byte = 0;
                return ::read(end, &byte, 1) == 1 ? try_to_open(kOutside) : kNoBox;
              }));
              enter_box({{{inside_.path(), Access::kWrite}}});
              boxed.set_value();
              if (::write(pipe[1], "x", 1) != 1) return kNoBox;
              for (std::future<int>& each : threads) {
                if (const int error = each.get(); error != EACCES) return error;
              }
              return EACCES;
            }),
            EACCES);
}

TEST_F(BoxOfFiles, SaysSoIfAThreadDoesNotFollow) {
  EXPECT_EQ(in_child([&] {
              std::promise<void> blocked;
              std::thread([&] {
                sigset_t all;
                sigfillset(&all);
                ::pthread_sigmask(SIG_BLOCK, &all, nullptr);
                blocked.set_value();
                for (;;) ::pause();
              }).detach();
              blocked.get_future().wait();
              const Boxed boxed = enter_box({});
              const bool is_said = boxed.text.find("a thread does not answer") != std::string::npos;
              return boxed.files == Part::kFailed && is_said && boxed.calls == Part::kInForce ? 0 : 1;
            }),
            0);
}

TEST_F(BoxOfFiles, OpensNoFileOutside) {
  const Box box{{{inside_.path(), Access::kWrite}}};
  const std::string there = outside_.file("there");
  std::ofstream(there) << "a secret";
  for (const std::string& path : {there, kOutside, std::string("/proc/self/mem"), std::string("/dev/null")}) {
    EXPECT_EQ(in_box(box, [&] { return try_to_open(path); }), EACCES) << path;
  }
  EXPECT_EQ(in_box(box, [&] { return try_to_open(there, O_WRONLY); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return try_to_make(outside_.file("new")); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return error_of(::unlink(there.c_str())); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return try_to_open(outside_.path(), O_RDONLY | O_DIRECTORY); }), EACCES);
  const std::string around = inside_.file("../" + fs::path(there).parent_path().filename().string() + "/there");
  EXPECT_EQ(in_box(box, [&] { return try_to_open(around); }), EACCES);
}

TEST_F(BoxOfFiles, FollowsNoLinkThatLeadsOutside) {
  const std::string link = inside_.file("link");
  fs::create_symlink(outside_.file("new"), link);
  EXPECT_EQ(in_box({{{inside_.path(), Access::kWrite}}}, [&] { return try_to_open(link, O_WRONLY | O_CREAT); }),
            EACCES);
  EXPECT_FALSE(fs::exists(outside_.file("new")));
}

TEST_F(BoxOfFiles, MovesNoFileInOrOut) {
  std::ofstream(inside_.file("ours")) << "ours";
  std::ofstream(outside_.file("theirs")) << "theirs";
  const Box box{{{inside_.path(), Access::kWrite}}};
  const auto move = [&](const std::string& from, const std::string& to) {
    return in_box(box, [&] { return error_of(std::rename(from.c_str(), to.c_str())); });
  };
  EXPECT_THAT(move(inside_.file("ours"), outside_.file("ours")), testing::AnyOf(EACCES, EXDEV));
  EXPECT_THAT(move(outside_.file("theirs"), inside_.file("theirs")), testing::AnyOf(EACCES, EXDEV));
}

TEST_F(BoxOfFiles, WritesRenamesAndRemovesWhereItMay) {
  const std::string made = inside_.file("made"), renamed = inside_.file("renamed");
  EXPECT_EQ(in_box({{{inside_.path(), Access::kWrite}}},
                   [&] {
                     if (const int error = try_to_make(made)) return error;
                     if (const int error = try_to_open(made, O_WRONLY | O_TRUNC)) return error;
                     if (const int error = error_of(std::rename(made.c_str(), renamed.c_str()))) return error;
                     if (const int error = try_to_make(made)) return error;
                     return error_of(::unlink(made.c_str()));
                   }),
            0);
  EXPECT_TRUE(fs::exists(renamed));
  EXPECT_FALSE(fs::exists(made));
  EXPECT_EQ(in_box({{{inside_.path(), Access::kWrite}}}, [&] { return try_to_open(renamed); }), EACCES) << "nor reads";
}

TEST_F(BoxOfFiles, OnlyRemovesWhereItMayRemove) {
  const std::string path = inside_.file("socket");
  std::ofstream(path) << "x";
  const Box box{{{inside_.path(), Access::kRemove}}};
  EXPECT_EQ(in_box(box, [&] { return try_to_open(path); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return try_to_open(path, O_WRONLY); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return try_to_make(inside_.file("new")); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return error_of(::unlink(path.c_str())); }), 0);
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(BoxOfFiles, ReadsOneFileOfAFolder) {
  const std::string ours = inside_.file("ours"), others = inside_.file("others");
  std::ofstream(ours) << "ours";
  std::ofstream(others) << "others";
  const Box box{{{ours, Access::kRead}, {inside_.file("missing"), Access::kRead}}};
  EXPECT_EQ(in_box(box, [&] { return try_to_open(ours); }), 0);
  EXPECT_EQ(in_box(box, [&] { return try_to_open(ours, O_WRONLY); }), EACCES);
  EXPECT_EQ(in_box(box, [&] { return try_to_open(others); }), EACCES);
}

TEST_F(BoxOfFiles, CountsAsManyProcessorsAsBefore) {
  const unsigned before = std::thread::hardware_concurrency();
  EXPECT_EQ(in_box({{{inside_.path(), Access::kWrite}}},
                   [&] { return std::thread::hardware_concurrency() == before ? 0 : 1; }),
            0);
}

TEST_F(BoxOfFiles, AnAuditLogIsRenewedAtItsLimit) {
  const std::string path = inside_.file("audit");
  EXPECT_EQ(in_child([&] {
              Audit::Options options;
              options.file = path;
              options.max_file_bytes = 1000;
              Audit audit(options);
              if (enter_box({{{inside_.path(), Access::kWrite}}}).files != Part::kInForce) return kNoBox;
              for (int i = 0; i < 50; ++i) audit.note(AuditEvent::kOpened, "somebody", "board 0: a session begins");
              return 0;
            }),
            0);
  EXPECT_GT(fs::file_size(path + ".1"), 900u);
  EXPECT_GT(fs::file_size(path), 0u);
  EXPECT_LE(fs::file_size(path), 1000u);
}

}  // namespace
}  // namespace gicube::emu
