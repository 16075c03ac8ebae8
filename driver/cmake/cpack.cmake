# script/package, for Debian 12: gicube (libraries, programs, their manual pages; gicube-scene too, since the
# programs need what it needs), gicube-dev (headers, messages, CMake, pkg-config), python3-gicube (the Python package,
# gicube-sweep, gicube-explore),
# gicube-doc (documents, examples); where there is an MPI gicube-mpi (its library and header).
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME gicube)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "The GI-Cube SDK's authors <gicube@example.org>")  # chosen: no address is the project's own
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_SOURCE_DIR}/debian_files.cmake)
set(CPACK_COMPONENTS_ALL runtime dev doc python)
if(TARGET gicube-mpi)
  list(APPEND CPACK_COMPONENTS_ALL mpi)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)      # what the programs link decides what the packages need
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME gicube)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION
"emulated GI-Cube volumetric ray tracing board, and its driver
The driver library (C++ and C), gicube-scene (volume files, scenes, their
voxels), gicube-board (the board's emulator) and
the programs that use them.")
foreach(file postinst prerm postrm triggers)
  list(APPEND CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/${file})
endforeach()
set(CPACK_DEBIAN_DEV_PACKAGE_NAME gicube-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "gicube (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_DEV_DESCRIPTION
"GI-Cube driver: headers, messages, CMake package, pkg-config
What a program needs to build on the GI-Cube driver and to test itself
against emulated boards.")
set(CPACK_DEBIAN_DEV_PACKAGE_SUGGESTS gicube-doc)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-gicube)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
# The module is for one version of the interpreter.
math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "gicube (= ${PROJECT_VERSION}), python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python}), \
python3-numpy, python3-openimageio, python3-tqdm")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib, python3-optuna, python3-pytest, python3-tqdm")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION
"emulated GI-Cube board from Python
The GI-Cube driver, its volume files, scenes and plans, with numpy arrays
for volumes, rays and pictures; gicube-sweep, which renders over a grid of
parameters; and gicube-explore, which searches the board's configurations.")
set(CPACK_DEBIAN_MPI_PACKAGE_NAME gicube-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "gicube (= ${PROJECT_VERSION}), mpi-default-bin")
set(CPACK_DEBIAN_MPI_PACKAGE_SUGGESTS gicube-dev)
set(CPACK_DEBIAN_MPI_DESCRIPTION
"GI-Cube driver on several hosts, by MPI
What gicube-render --mpi loads, and a header for programs that share a
volume among the ranks of an MPI job.")
set(CPACK_DEBIAN_DOC_PACKAGE_NAME gicube-doc)
set(CPACK_DEBIAN_DOC_PACKAGE_SECTION doc)
set(CPACK_DEBIAN_DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_DOC_DESCRIPTION
"GI-Cube SDK: guide, reference, studies, examples
Documents of the GI-Cube driver, its emulated board and the programs that
use them, with scenes and small applications; as pages for a browser too, with
the API of C++, C and Python.")

# Debian's place for a package's license; each package has its own. LICENSE is a document.
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  install(FILES copyright DESTINATION share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME} COMPONENT ${component})
endforeach()
include(CPack)
