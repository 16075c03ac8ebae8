// The application with a scan of its own, without a test framework: what does not hold is thrown.
#include <gicube/scene/volume_file.h>
#include <gicube/testing.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "turntable.h"

namespace {

using gicube::test::require;

// A bar along x with twice the width of its depth: seen from -y it is broad, and narrow after a quarter turn.
void write_bar(const std::filesystem::path& path) {
  const gicube::Dims dims{16, 4, 8};
  const std::vector<float> values(16 * 4 * 8, 1);
  std::vector<float> scan = values;
  scan[0] = 0;  // a value range needs two values
  gicube::scene::FloatVolume volume;
  volume.dims = dims;
  volume.values = scan;
  gicube::scene::write_volume(volume, path);
}

// Pixels of the row above the table that the thing covers.
int width_of(const gicube::Image& image) {
  int covered = 0;
  for (int x = 0; x < image.width; ++x) covered += image.at(x, image.height * 2 / 5).alpha > 2000 ? 1 : 0;
  return covered;
}

}  // namespace

int main() {
  char folder[] = "turntable-XXXXXX";
  const std::filesystem::path scan = std::filesystem::path(mkdtemp(folder)) / "bar.nrrd";
  write_bar(scan);
  gicube::Board board = gicube::test::BoardSetup::from_environment().open();
  const gicube::scene::Scene scene = example::turntable(scan);
  const int broad = width_of(example::picture(board, scene, 0));
  const int narrow = width_of(example::picture(board, scene, 2));  // 90 degrees
  std::filesystem::remove_all(folder);
  require({broad > 20, "the scan does not show: " + std::to_string(broad) + " pixels"});
  require({narrow > 5 && narrow < broad / 2,
           "the scan has not turned: " + std::to_string(narrow) + " pixels, " + std::to_string(broad) + " before"});

  try {
    example::picture(board, example::turntable("no such file.nrrd"), 0);
    require({false, "a scan that is not there was taken"});
  } catch (const gicube::scene::InputError& error) {
    require({error.file() == "no such file.nrrd", "the error names " + error.file()});
  }
}
