// Python's interpreter and the threads of the driver: who has its lock, and what becomes of a thread when the
// interpreter ends.
#pragma once

#include <pybind11/pybind11.h>

#include <cxxabi.h>
#include <unistd.h>

#include <optional>

namespace gicube::python {

// An interpreter that ends has each other thread that asks for its lock unwound, as by pthread_exit(). Destructors and
// calls of the driver must not be left so: the thread waits here, and ends with the process.
auto or_wait_for_the_end(const auto& work) {
  try {
    return work();
  } catch (const abi::__forced_unwind&) {
    for (;;) ::pause();
  }
}

// Other threads of Python run while it lives.
class Released {
 public:
  Released() = default;
  ~Released() {
    or_wait_for_the_end([this] { PyEval_RestoreThread(thread_); });
  }
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* const thread_ = PyEval_SaveThread();
};

auto without_interpreter(const auto& work) {
  const Released released;
  return work();
}

// Runs work that needs the interpreter, on any thread.
auto with_interpreter(const auto& work) {
  std::optional<pybind11::gil_scoped_acquire> held;
  or_wait_for_the_end([&held] { held.emplace(); });
  return or_wait_for_the_end(work);
}

}  // namespace gicube::python
