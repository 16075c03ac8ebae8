# Writes OUTPUT, a source with all files of FOLDER as page_files() (page_files.h). Run by cmake -P.
set(types html text/html js text/javascript css text/css svg image/svg+xml)
file(GLOB files ${FOLDER}/*.html ${FOLDER}/*.js ${FOLDER}/*.css ${FOLDER}/*.svg)
set(arrays "")
set(entries "")
set(number 0)
foreach(file ${files})
  get_filename_component(name ${file} NAME)
  get_filename_component(extension ${file} LAST_EXT)
  string(SUBSTRING ${extension} 1 -1 extension)
  list(FIND types ${extension} at)
  math(EXPR at "${at} + 1")
  list(GET types ${at} type)
  file(READ ${file} bytes HEX)
  # A text, which compilers read much faster than a list of characters.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" bytes "${bytes}")
  string(APPEND arrays "constexpr char kFile${number}[] = \"${bytes}\";\n")
  string(APPEND entries "  PageFile{\"${name}\", \"${type}\", {kFile${number}, sizeof(kFile${number}) - 1}},\n")
  math(EXPR number "${number} + 1")
endforeach()
string(PREPEND arrays
  "#include \"view/page_files.h\"\n\n#include <array>\n\nnamespace gicube::samples::view {\nnamespace {\n\n")
file(WRITE ${OUTPUT} "${arrays}
constexpr std::array<PageFile, ${number}> kPageFiles{{\n${entries}}};\n
}  // namespace\n\nstd::span<const PageFile> page_files() { return kPageFiles; }\n
}  // namespace gicube::samples::view\n")
