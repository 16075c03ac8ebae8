// One function a command. Each prints to standard output and returns the exit code: 0 good, 1 not.
#pragma once

#include "client.h"
#include "options.h"

namespace gicube::smi {

int list(const Options& options);
int info(const Options& options);
int top(const Options& options);
int validate(const Options& options);
int reset(const Options& options);
int faults(const Options& options);
int trace(const Options& options);
int doctor(const Options& options);

}  // namespace gicube::smi
