#include "answer_watch.h"

#include <exception>
#include <utility>

namespace gicube {

AnswerWatch::~AnswerWatch() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void AnswerWatch::add(std::shared_ptr<Link> link, std::uint32_t request, std::shared_ptr<Event> event) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({std::move(link), request, std::move(event)});
  }
  changed_.notify_all();
  if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
}

void AnswerWatch::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
    if (ends_) return;
    const Watched next = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    try {
      next.link->finish(next.request);
    } catch (const std::exception&) {  // the application's next call throws the same
    }
    next.event->happen();
    lock.lock();
  }
}

}  // namespace gicube
