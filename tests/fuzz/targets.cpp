#include "targets.h"

namespace gicube::fuzz {

const std::vector<Target>& targets() {
  static const std::vector<Target> list{
      {"board", board},
      {"bus", bus},
      {"c_api", c_api},
      {"capture", capture},
      {"checkpoint", checkpoint},
      {"composition", composition},
      {"cone_scan", cone_scan},
      {"config", config},
      {"ctsimu", ctsimu},
      {"dicom", dicom},
      {"hdf5", hdf5},
      {"legacy_vtk", legacy_vtk},
      {"link", link},
      {"mesh", mesh},
      {"meta_image", meta_image},
      {"nifti", nifti},
      {"nrrd", nrrd},
      {"numpy", numpy},
      {"openvdb", openvdb},
      {"orbit", orbit},
      {"pci", pci},
      {"pfm", pfm},
      {"projection_matrix", projection_matrix},
      {"scene", scene},
      {"transfer_function", transfer_function},
      {"uri", uri},
      {"view_http", view_http},
      {"view_message", view_message},
      {"vti", vti},
  };
  return list;
}

}  // namespace gicube::fuzz
