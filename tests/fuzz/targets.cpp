#include "targets.h"

namespace gicube::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> list{
      {"board", board},   {"bus", bus},   {"c_api", c_api}, {"capture", capture},
      {"config", config}, {"link", link}, {"mesh", mesh},   {"meta_image", meta_image},
      {"nifti", nifti},   {"nrrd", nrrd}, {"scene", scene}, {"transfer_function", transfer_function},
      {"uri", uri},
  };
  return list;
}

}  // namespace gicube::fuzz
