// The parts of the module gicube._core, each with its classes and functions.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <unistd.h>

#include <memory>
#include <string>
#include <utility>

#include "gicube/board.h"
#include "gicube/error.h"
#include "gicube/level_of_detail.h"
#include "interpreter.h"

namespace gicube::python {

void add_errors();
void add_board(pybind11::module_& module);
void add_group(pybind11::module_& module);
void add_plans(pybind11::module_& module);
void add_projector(pybind11::module_& module);
void add_scenes(pybind11::module_& module);

// Python's handle to a board, or to several. A call keeps it alive, so close() on another thread ends it after that
// call.
template <typename T>
class Owned {
 public:
  explicit Owned(std::shared_ptr<T> what) : what_(std::move(what)), process_(::getpid()) {}
  // In a forked process the session is the parent's: it is left alone.
  ~Owned() {
    if (is_forked()) {
      // Never destroyed: its threads are the parent's.
      [[maybe_unused]] const auto* const kept = std::make_unique<std::shared_ptr<T>>(std::move(what_)).release();
    } else {
      close();
    }
  }
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;

  // Throws DeviceLost if it is closed, Error in a forked process.
  std::shared_ptr<T> board() const {
    if (is_forked()) {
      throw Error("this board was opened by the process " + std::to_string(process_) + ": a forked one opens its own");
    }
    if (!what_) throw DeviceLost("the board is closed");
    return what_;
  }
  void close() {
    if (is_forked()) return;
    std::shared_ptr<T> last;
    last.swap(what_);
    without_interpreter([&last] { last.reset(); });
  }
  // Called when the interpreter ends. A call that is still in progress belongs to a daemon thread, which does not end:
  // it keeps its board.
  void close_if_idle() {
    if (what_.use_count() == 1) close();
  }

 private:
  bool is_forked() const { return process_ != ::getpid(); }

  std::shared_ptr<T> what_;
  pid_t process_;
};
using Handle = Owned<Board>;

// Runs Python's handlers of signals that came, on its main thread. Throws what they raise: KeyboardInterrupt for
// Ctrl-C.
void take_signals();

// Python's callable(done, all), or None; signals are looked for in between. The callable must outlive it.
Progress progress_of(pybind11::handle callable);

// Python's callable(event), or None.
ScatteringRoutine routine_of(pybind11::handle callable);

// The view of a gicube.Volume: points into its arrays.
VolumeView view_of(pybind11::handle volume);
VolumeStream stream_of(pybind11::handle volume);

// The view of a gicube.Volume that coarser() made.
DerivedVolume derived_of(pybind11::handle volume);

// A gicube.Volume of samples as bytes, and of further fields.
pybind11::object volume_of(const pybind11::array& bytes, SampleType type, const Dims& dims,
                           const pybind11::dict& fields);

}  // namespace gicube::python
