// The parts of the module gicube._core, each with its classes and functions.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>

#include "gicube/board.h"
#include "gicube/level_of_detail.h"

namespace gicube::python {

void add_errors();
void add_board(pybind11::module_& module);
void add_plans(pybind11::module_& module);
void add_scenes(pybind11::module_& module);

// What Python holds of a board. A call keeps it alive, so close() on another thread ends it after that call.
class Handle {
 public:
  explicit Handle(Board board);
  // In a forked process the session is the parent's: it is left alone.
  ~Handle();
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  // Throws DeviceLost if it is closed, Error in a forked process.
  std::shared_ptr<Board> board() const;
  void close();

 private:
  bool is_forked() const;

  std::shared_ptr<Board> board_;
  pid_t process_;
};

// Python's callable(done, all), or None; signals are looked for in between. The callable must outlive it.
Progress progress_of(pybind11::handle callable);

// Python's callable(event), or None.
ScatteringRoutine routine_of(pybind11::handle callable);

// Of a gicube.Volume: points into its arrays.
VolumeView view_of(pybind11::handle volume);
VolumeStream stream_of(pybind11::handle volume);

// Of a gicube.Volume that coarser() made.
DerivedVolume derived_of(pybind11::handle volume);

// A gicube.Volume of samples as bytes, and of further fields.
pybind11::object volume_of(const pybind11::array& bytes, SampleType type, const Dims& dims,
                           const pybind11::dict& fields);

}  // namespace gicube::python
