// Cancellation of reading a file.
#pragma once

#include <functional>
#include <utility>

namespace gicube::scene {

// During its lifetime, reading volumes on this thread calls `look` about once per mebibyte. An exception thrown by
// `look` ends the reading.
class WhileReading {
 public:
  explicit WhileReading(std::function<void()> look) : look_(std::move(look)), before_(std::exchange(current_, this)) {}
  ~WhileReading() { current_ = before_; }
  WhileReading(const WhileReading&) = delete;
  WhileReading& operator=(const WhileReading&) = delete;

  // Called by the reader.
  static void look() {
    if (current_ != nullptr) current_->look_();
  }

 private:
  std::function<void()> look_;
  WhileReading* before_;
  static inline thread_local WhileReading* current_ = nullptr;
};

}  // namespace gicube::scene
