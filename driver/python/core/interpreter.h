// Python's interpreter and the driver's threads: holding its lock, and the end of threads with the interpreter.
#pragma once

#include <pybind11/pybind11.h>

#include <cxxabi.h>
#include <unistd.h>

#include <optional>

namespace gicube::python {

// While an interpreter ends, CPython unwinds each other thread that asks for its lock, as pthread_exit() does.
// Destructors and calls of the driver must not be left so: the thread waits here, and ends with the process.
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
    mine() = outer_;
    or_wait_for_the_end([this] { PyEval_RestoreThread(thread_); });
  }
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

  // The state of this thread of Python, which has released the lock, or null.
  static PyThreadState*& mine() {
    thread_local PyThreadState* state = nullptr;
    return state;
  }

 private:
  PyThreadState* const outer_ = mine();
  PyThreadState* const thread_ = mine() = PyEval_SaveThread();
};

// Holds the lock while it lives, on any thread. A thread of Python takes it with the state that it had. Looking a state
// up or making one reads the interpreter, which has been freed once it has ended.
class Held {
 public:
  Held() {
    or_wait_for_the_end([this] {
      if (thread_ != nullptr) {
        PyEval_RestoreThread(thread_);
      } else {
        while (Py_IsInitialized() == 0) ::pause();
        foreign_.emplace();
      }
    });
    Released::mine() = nullptr;
  }
  ~Held() {
    Released::mine() = thread_;
    if (thread_ != nullptr) PyEval_SaveThread();
  }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  PyThreadState* const thread_ = Released::mine();
  std::optional<pybind11::gil_scoped_acquire> foreign_;
};

auto without_interpreter(const auto& work) {
  const Released released;
  return work();
}

// Runs work that needs the interpreter, on any thread.
auto with_interpreter(const auto& work) {
  const Held held;
  return or_wait_for_the_end(work);
}

}  // namespace gicube::python
