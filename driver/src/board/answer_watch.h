// Waits for answers of the board on a thread of its own, so that no call of the application has to. Waiting also runs
// the link's watchdog and resumes its session.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>

#include "transport/event.h"
#include "transport/link.h"

namespace gicube {

class AnswerWatch {
 public:
  AnswerWatch() = default;
  // The links must be closed. All events have happened afterwards.
  ~AnswerWatch();
  AnswerWatch(const AnswerWatch&) = delete;
  AnswerWatch& operator=(const AnswerWatch&) = delete;

  // `event` happens when `request`, which was begun on the link, is answered or can't be answered any longer. Requests
  // are answered in the order of their begin.
  void add(std::shared_ptr<Link> link, std::uint32_t request, std::shared_ptr<Event> event);

 private:
  struct Watched {
    std::shared_ptr<Link> link;
    std::uint32_t request = 0;
    std::shared_ptr<Event> event;
  };
  void run();

  std::mutex mutex_;  // of all below but the thread
  std::condition_variable changed_;
  std::deque<Watched> waiting_;
  bool ends_ = false;
  std::thread thread_;  // from the first add() on
};

}  // namespace gicube
