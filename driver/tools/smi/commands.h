// The commands (Options::run).
#pragma once

#include "options.h"

namespace gicube::smi {

int list(const Options& options);
int info(const Options& options);
int top(const Options& options);
int validate(const Options& options);
int reset(const Options& options);
int show_faults(const Options& options);
int set_faults(const Options& options);
int clear_faults(const Options& options);
int log_faults(const Options& options);
int show_trace(const Options& options);
int start_trace(const Options& options);
int stop_trace(const Options& options);
int doctor(const Options& options);

}  // namespace gicube::smi
