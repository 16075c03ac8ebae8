# libgicube-scene.so, the component `scene` of find_package(gicube): from the objects of driver/scene. Its public
# headers name the driver's, and no header of the libraries that it reads files with.
add_library(gicube-scene SHARED)
add_library(gicube::scene ALIAS gicube-scene)
set(scene_script ${CMAKE_CURRENT_SOURCE_DIR}/gicube-scene.map)
set(scene_include ${PROJECT_SOURCE_DIR}/driver/scene/include)
file(GLOB scene_headers CONFIGURE_DEPENDS ${scene_include}/gicube/scene/*.h)
target_sources(gicube-scene
  PRIVATE $<TARGET_OBJECTS:gicube_scene>
  PUBLIC FILE_SET HEADERS BASE_DIRS ${scene_include} FILES ${scene_headers})
target_compile_features(gicube-scene INTERFACE cxx_std_20)
target_link_libraries(gicube-scene
  PUBLIC gicube
  PRIVATE gicube_scene_proto gicube_whole_file fmt::fmt ZLIB::ZLIB BZip2::BZip2 ${MINIZIP_LIBRARY} pugixml::pugixml
      PNG::PNG ${TEEM_LIBRARY} ${NIFTI_LIBRARY} Threads::Threads)
target_link_options(gicube-scene PRIVATE
  LINKER:--version-script=${scene_script} LINKER:--exclude-libs,ALL LINKER:--as-needed)
if(NOT GICUBE_SANITIZE AND NOT GICUBE_FUZZ)  # as libgicube.so
  target_link_options(gicube-scene PRIVATE LINKER:--no-undefined)
endif()
set_target_properties(gicube-scene PROPERTIES
  EXPORT_NAME scene
  LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${GICUBE_SOVERSION}
  LINK_DEPENDS ${scene_script}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib
  BUILD_WITH_INSTALL_RPATH ON  # or its bytes would depend on the folder of the build
  INSTALL_RPATH "$ORIGIN")  # libgicube.so lies beside it

install(TARGETS gicube-scene EXPORT gicubeSceneTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT dev
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
install(EXPORT gicubeSceneTargets NAMESPACE gicube:: DESTINATION ${cmake_dir} COMPONENT dev)
configure_file(gicube-scene.pc.in gicube-scene.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/gicube-scene.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT dev)

if(NOT GICUBE_PICTURES)
  return()
endif()
# libgicube-pictures.so, which they load when they need OpenImageIO (driver/scene/formats/pictures/picture_library.h).
# Nothing links it.
add_library(gicube-pictures SHARED ${PROJECT_SOURCE_DIR}/driver/scene/pictures/pictures.cpp
    ${PROJECT_SOURCE_DIR}/driver/scene/pictures/tiff.cpp)
target_include_directories(gicube-pictures PRIVATE ${PROJECT_SOURCE_DIR}/driver ${PROJECT_SOURCE_DIR}/driver/include
    ${scene_include})
target_link_libraries(gicube-pictures PRIVATE gicube_options PkgConfig::OpenImageIO TIFF::TIFF)
target_link_options(gicube-pictures PRIVATE LINKER:--as-needed)
set_target_properties(gicube-pictures PROPERTIES
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
  VERSION ${PROJECT_VERSION} SOVERSION ${GICUBE_SOVERSION}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
add_dependencies(gicube_scene gicube-pictures)  # whoever links that one may load this one
install(TARGETS gicube-pictures LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_SKIP)

# libgicube-dicom.so, libgicube-hdf5.so and libgicube-openvdb.so, loaded the same way
# (driver/scene/formats/volume_library.h). Debian 12's CMake configs of DCMTK and OpenVDB name parts that nothing here
# needs.
function(gicube_volume_library name)
  add_library(gicube-${name} SHARED ${PROJECT_SOURCE_DIR}/driver/scene/libraries/${name}.cpp)
  target_include_directories(gicube-${name} PRIVATE ${PROJECT_SOURCE_DIR}/driver ${PROJECT_SOURCE_DIR}/driver/include
      ${scene_include})
  target_link_libraries(gicube-${name} PRIVATE gicube_options fmt::fmt ${ARGN})
  target_link_options(gicube-${name} PRIVATE LINKER:--as-needed)
  set_target_properties(gicube-${name} PROPERTIES
    CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    VERSION ${PROJECT_VERSION} SOVERSION ${GICUBE_SOVERSION}
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
  add_dependencies(gicube_scene gicube-${name})
  install(TARGETS gicube-${name} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_SKIP)
endfunction()
gicube_volume_library(dicom dcmdata dcmjpeg dcmjpls oflog ofstd)
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5)
gicube_volume_library(hdf5 PkgConfig::HDF5)
gicube_volume_library(openvdb openvdb tbb)
