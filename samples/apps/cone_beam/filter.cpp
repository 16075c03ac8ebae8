// Ramp filter along rows.
#include <fftw3.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <mutex>
#include <numbers>

#include "cone_beam/fdk.h"

namespace gicube::samples {
namespace {

using std::numbers::pi;

// FFTW's planner is not thread-safe; execution of plans is.
std::mutex planner;

struct Free {
  void operator()(void* memory) const { fftw_free(memory); }
};
template <typename T>
using Buffer = std::unique_ptr<T[], Free>;

Buffer<double> reals(std::size_t count) { return Buffer<double>(fftw_alloc_real(count)); }
Buffer<fftw_complex> complexes(std::size_t count) { return Buffer<fftw_complex>(fftw_alloc_complex(count)); }

double window_at(Window window, double part) {  // of the highest frequency
  switch (window) {
    case Window::kRamLak: return 1;
    case Window::kSheppLogan: return part == 0 ? 1 : std::sin(pi * part / 2) / (pi * part / 2);
    case Window::kHann: return 0.5 * (1 + std::cos(pi * part));
  }
  return 1;
}

}  // namespace

RampFilter::RampFilter(int samples, double pitch, Window window)
    : samples_(samples), padded_(std::bit_ceil(2 * static_cast<std::size_t>(samples))) {
  const std::size_t half = padded_ / 2 + 1;
  const auto time = reals(padded_);
  const auto spectrum = complexes(half);
  {
    const std::lock_guard lock(planner);
    const int size = static_cast<int>(padded_);
    forward_.reset(fftw_plan_dft_r2c_1d(size, time.get(), spectrum.get(), FFTW_ESTIMATE));
    backward_.reset(fftw_plan_dft_c2r_1d(size, spectrum.get(), time.get(), FFTW_ESTIMATE));
  }
  // The band-limited ramp in space (Kak and Slaney, eq. 61 of chapter 3), times the pitch of the convolution's sum. Its
  // transform has the right mean; a ramp of frequencies would have none.
  std::fill_n(time.get(), padded_, 0.0);
  time[0] = 1 / (4 * pitch);
  for (std::size_t n = 1; n < padded_ / 2; n += 2) {
    time[n] = time[padded_ - n] = -1 / (pi * pi * static_cast<double>(n * n) * pitch);
  }
  fftw_execute_dft_r2c(forward_.get(), time.get(), spectrum.get());
  for (std::size_t k = 0; k < half; ++k) {
    const double part = static_cast<double>(k) / (static_cast<double>(padded_) / 2);
    response_.push_back(spectrum[k][0] * window_at(window, part) / static_cast<double>(padded_));
  }
}

void RampFilter::End::operator()(fftw_plan_s* plan) const {
  const std::lock_guard lock(planner);
  fftw_destroy_plan(plan);
}

void RampFilter::apply(const double* row, double* out) const {
  const auto time = reals(padded_);
  const auto spectrum = complexes(response_.size());
  std::fill(std::copy_n(row, samples_, time.get()), time.get() + padded_, 0.0);
  fftw_execute_dft_r2c(forward_.get(), time.get(), spectrum.get());
  for (std::size_t k = 0; k < response_.size(); ++k) {
    for (double& part : spectrum[k]) part *= response_[k];
  }
  fftw_execute_dft_c2r(backward_.get(), spectrum.get(), time.get());
  std::copy_n(time.get(), samples_, out);
}

double RampFilter::gain() const {
  std::vector<double> first(static_cast<std::size_t>(samples_)), out(first.size());
  first[0] = 1;
  apply(first.data(), out.data());
  double sum = -std::abs(out[0]);  // of both sides
  for (const double value : out) sum += 2 * std::abs(value);
  return sum;
}

}  // namespace gicube::samples
