# Writes FOLDER/all.cc, which includes the sources of the class NAME that Verilator has written there. Their names are
# known only then. Verilator leaves its files as they are if no source of the module has changed; so does this.
file(STRINGS ${FOLDER}/${NAME}__verFiles.dat sources REGEX "^T.*\\.cpp\"$")
list(TRANSFORM sources REPLACE ".*/([^/]+)\"$" "#include \"\\1\"\n")
list(SORT sources)
list(JOIN sources "" text)
set(before "")
if(EXISTS ${FOLDER}/all.cc)
  file(READ ${FOLDER}/all.cc before)
endif()
if(NOT text STREQUAL before)
  file(WRITE ${FOLDER}/all.cc "${text}")
endif()
