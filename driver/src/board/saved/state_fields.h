// Reads and writes the driver's fields of a checkpoint (proto/gicube/v1/checkpoint.proto) in protobuf's wire format.
// The driver does not link a protobuf library.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/archive.h"

namespace gicube {

// Writes a message DriverState.
class FieldWriter : public Archive {
 public:
  FieldWriter() : Archive(false) {}
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void exchange(Field& field) override;

  std::vector<std::uint8_t> bytes_;
};

// Reads a message DriverState. Throws CheckpointFault.
class FieldReader : public Archive {
 public:
  explicit FieldReader(std::span<const std::uint8_t> message) : Archive(true), rest_(message) {}
  void end() const;  // throws CheckpointFault if fields are left

 private:
  void exchange(Field& field) override;

  std::span<const std::uint8_t> rest_;
};

// The driver's part of a checkpoint, as a part of its bytes. Throws CheckpointFault if the checkpoint is damaged or has
// no such part.
std::span<const std::uint8_t> driver_part(std::span<const std::uint8_t> checkpoint);

}  // namespace gicube
