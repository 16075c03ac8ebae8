// What the fuzzers feed: each target takes any bytes and returns. Only what a docstring allows may be thrown inside it;
// everything else that leaves a target, and every broken promise about what came back, is a finding.
//
// Two programs run them: gicube-fuzz-NAME, by libFuzzer (script/fuzz), and corpus_test, which only plays the corpus.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace gicube::fuzz {

using Bytes = std::span<const std::uint8_t>;

// Files.
void capture(Bytes input);
void composition(Bytes input);
void cone_scan(Bytes input);
void config(Bytes input);
void ctsimu(Bytes input);
void dicom(Bytes input);
void hdf5(Bytes input);
void mesh(Bytes input);
void meta_image(Bytes input);
void nifti(Bytes input);
void numpy(Bytes input);
void legacy_vtk(Bytes input);
void nrrd(Bytes input);
void openvdb(Bytes input);
void pfm(Bytes input);
void orbit(Bytes input);
void projection_matrix(Bytes input);
void scene(Bytes input);
void transfer_function(Bytes input);
void uri(Bytes input);
void vti(Bytes input);

// The board and the bus.
void board(Bytes input);
void checkpoint(Bytes input);
void bus(Bytes input);
void link(Bytes input);
void pci(Bytes input);

// The driver's C ABI.
void c_api(Bytes input);

// gicube-view.
void view_http(Bytes input);
void view_message(Bytes input);

struct Target {
  const char* name;  // also of its folder in corpus/
  void (*run)(Bytes);
};
const std::vector<Target>& targets();

class Finding : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

// A promise that the code under test made.
inline void expect(bool holds, const char* promise) {
  if (!holds) throw Finding(promise);
}

inline std::string_view text_of(Bytes input) { return {reinterpret_cast<const char*>(input.data()), input.size()}; }

}  // namespace gicube::fuzz
