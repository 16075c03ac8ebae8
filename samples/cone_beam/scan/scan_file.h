// Scans as protobuf text files (proto/gicube/v1/cone_scan.proto).
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "cone_beam/scan/description.h"

namespace gicube::samples {

// Strict, as scene files are: an unknown field, a value of the wrong type, out of range or missing is an error. Throws InputError with
// all faults, one a line: "NAME:LINE:COLUMN: ..." for the text, "NAME: field.path: expected ..., got ..." for its meaning.
// Relative paths in `text` are taken from `folder`.
ScanDescription parse_scan(const std::string& text, const std::string& name, const std::filesystem::path& folder);
// The same for a file. Throws InputError also if it can't be read.
ScanDescription read_scan_file(const std::filesystem::path& path);

// Types of raw samples by the names of cone_scan.proto.
inline const std::map<std::string, SampleType> kRawTypes{{"uint8", SampleType::kUint8},
                                                         {"uint16", SampleType::kUint16},
                                                         {"int16", SampleType::kInt16},
                                                         {"float32", SampleType::kFloat32}};
// Nothing for another name.
std::optional<SampleType> raw_type(const std::string& name);

// The text of a description. Files in `folder` are named relative to it.
std::string scan_text(const ScanDescription& description, const std::filesystem::path& folder);
// Throws FileError; a file that was there stays until the new one is whole.
void write_scan_file(const ScanDescription& description, const std::filesystem::path& path);

}  // namespace gicube::samples
