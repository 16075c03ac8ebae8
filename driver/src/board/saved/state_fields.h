// A checkpoint's fields as bytes (proto/gicube/v1/checkpoint.proto), by protobuf's wire format: the driver needs no
// protobuf library for these few.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gicube/archive.h"

namespace gicube {

// Makes the bytes of a message DriverState.
class FieldWriter : public Archive {
 public:
  FieldWriter() : Archive(false) {}
  std::vector<std::uint8_t> take() { return std::move(bytes_); }

 private:
  void exchange(Field& field) override;

  std::vector<std::uint8_t> bytes_;
};

// Reads them. Throws CheckpointFault.
class FieldReader : public Archive {
 public:
  explicit FieldReader(std::span<const std::uint8_t> message) : Archive(true), rest_(message) {}
  void end() const;  // all was asked for

 private:
  void exchange(Field& field) override;

  std::span<const std::uint8_t> rest_;
};

// The driver's part in a checkpoint, which is a part of its bytes. Throws CheckpointFault: they are damaged, or have
// none.
std::span<const std::uint8_t> driver_part(std::span<const std::uint8_t> checkpoint);

}  // namespace gicube
