# Files that Debian wants in each package and CMake does not install: compressed manual pages, a changelog, an entry for
# the site in doc-base. CPack runs this between installing and packaging.
file(GLOB manuals ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/man/man*/*.[1-9])
foreach(manual ${manuals})
  execute_process(COMMAND gzip -9n ${manual} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
string(TIMESTAMP now "%a, %d %b %Y %H:%M:%S +0000" UTC)  # SOURCE_DATE_EPOCH, if set
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(folder ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}/usr/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  set(changelog ${folder}/changelog)
  file(WRITE ${changelog} "gicube (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * Version ${CPACK_PACKAGE_VERSION}. CHANGELOG.md in gicube-doc says what is new.

 -- ${CPACK_PACKAGE_CONTACT}  ${now}
")
  execute_process(COMMAND gzip -9n ${changelog} COMMAND_ERROR_IS_FATAL ANY)
endforeach()

set(doc ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/doc/usr/share)
if(EXISTS ${doc}/doc/gicube/html/index.html)
  file(WRITE ${doc}/doc-base/gicube "Document: gicube
Title: GI-Cube SDK
Author: The GI-Cube SDK's authors
Abstract: Guide, reference and studies of the GI-Cube driver and its
 emulated board, with the API of C++, C and Python.
Section: Programming

Format: HTML
Index: /usr/share/doc/gicube/html/index.html
Files: /usr/share/doc/gicube/html/*.html
")
endif()
