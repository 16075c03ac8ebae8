# libgicube-mpi.so, the component `mpi` of find_package(gicube): RayExchange over MPI, of driver/hosts. Built where
# there is an MPI; nothing else of the SDK links one: gicube-render loads this library when it is told to.
find_package(MPI COMPONENTS C)
if(NOT MPI_C_FOUND)
  message(STATUS "no MPI (Debian's libopenmpi-dev or libmpich-dev): gicube-mpi is left out")
  return()
endif()
add_library(gicube-mpi SHARED ${PROJECT_SOURCE_DIR}/driver/hosts/mpi_exchange.cpp)
add_library(gicube::mpi ALIAS gicube-mpi)
target_sources(gicube-mpi
  PUBLIC FILE_SET HEADERS BASE_DIRS ${hosts_include} FILES ${hosts_include}/gicube/mpi.h)
target_compile_features(gicube-mpi INTERFACE cxx_std_20)
target_link_libraries(gicube-mpi PUBLIC gicube PRIVATE gicube_options MPI::MPI_C)
target_link_options(gicube-mpi PRIVATE
  LINKER:--version-script=${version_script} LINKER:--exclude-libs,ALL LINKER:--as-needed)
if(NOT GICUBE_SANITIZE)  # as libgicube.so
  target_link_options(gicube-mpi PRIVATE LINKER:--no-undefined)
endif()
set_target_properties(gicube-mpi PROPERTIES
  EXPORT_NAME mpi
  CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
  VERSION ${PROJECT_VERSION} SOVERSION ${GICUBE_SOVERSION}
  LINK_DEPENDS ${version_script}
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib
  BUILD_WITH_INSTALL_RPATH ON
  INSTALL_RPATH "$ORIGIN")  # libgicube.so lies beside it

install(TARGETS gicube-mpi EXPORT gicubeMpiTargets
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT mpi
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT mpi)
install(EXPORT gicubeMpiTargets NAMESPACE gicube:: DESTINATION ${cmake_dir} COMPONENT mpi)
