# Files that become part of the program. Included by the build it defines tessera_embed(); run as a
# script, `cmake -DFOLDER=... -DFUNCTION=... -DOUTPUT=... -P embed.cmake`, it writes the source.

# tessera_embed(TARGET FOLDER FUNCTION [DEPENDS file...])
#   Compiles into TARGET the function std::optional<EmbeddedFile> FUNCTION(std::string_view path) of
#   namespace tessera over all files of FOLDER (web/embedded_file.h), as they are when it is built.
#   TARGET must link `web`. DEPENDS names what tells that the files have changed where another rule
#   makes them; without it they are sources.
function(tessera_embed target folder function)
  cmake_parse_arguments(EMBED "" "" "DEPENDS" ${ARGN})
  get_filename_component(folder "${folder}" ABSOLUTE)
  set(output "${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp")
  set(script "${CMAKE_SOURCE_DIR}/cmake/embed.cmake")
  set(files "${EMBED_DEPENDS}")
  if(NOT files)
    file(GLOB_RECURSE files CONFIGURE_DEPENDS "${folder}/*")
  endif()
  add_custom_command(OUTPUT "${output}"
    COMMAND "${CMAKE_COMMAND}" "-DFOLDER=${folder}" "-DFUNCTION=${function}" "-DOUTPUT=${output}"
            -P "${script}"
    DEPENDS "${script}" ${files})
  target_sources(${target} PRIVATE "${output}")
  # Large constants are no part of a group of sources that is compiled again with each of them.
  set_source_files_properties("${output}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

if(NOT CMAKE_SCRIPT_MODE_FILE)
  return()
endif()

set(type_html "text/html; charset=utf-8")
set(type_css "text/css; charset=utf-8")
set(type_js "text/javascript; charset=utf-8")
set(type_json "application/json")
set(type_txt "text/plain; charset=utf-8")
set(type_svg "image/svg+xml")
set(type_png "image/png")
set(type_woff2 "font/woff2")
file(GLOB_RECURSE files RELATIVE "${FOLDER}" "${FOLDER}/*")
list(SORT files)
set(cases "")
set(constants "")
set(index 0)
foreach(name IN LISTS files)
  file(READ "${FOLDER}/${name}" bytes HEX)
  if(bytes STREQUAL "")
    message(FATAL_ERROR "${FOLDER}/${name}: is empty")
  endif()
  set(is_gzipped false)
  if(name MATCHES "\\.gz$")
    set(is_gzipped true)
    string(REGEX REPLACE "\\.gz$" "" name "${name}")
  endif()
  get_filename_component(extension "${name}" LAST_EXT)
  string(REGEX REPLACE "^\\." "" extension "${extension}")
  if(NOT DEFINED type_${extension})
    message(FATAL_ERROR "${FOLDER}/${name}: of no type that cmake/embed.cmake knows")
  endif()
  string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
  string(APPEND constants "constexpr unsigned char kFile${index}[] = {${bytes}};\n")
  if(name STREQUAL "index.html")
    set(name "")
  endif()
  string(APPEND cases "  if (path == \"/${name}\") {
    return EmbeddedFile{\"${type_${extension}}\", text(kFile${index}), ${is_gzipped}};\n  }\n")
  math(EXPR index "${index} + 1")
endforeach()
if(index EQUAL 0)
  message(FATAL_ERROR "${FOLDER}: has no files")
endif()
file(WRITE "${OUTPUT}" "#include \"web/embedded_file.h\"

#include <cstddef>
#include <optional>
#include <string_view>

namespace tessera {
namespace {

template <size_t N>
std::string_view text(const unsigned char (&bytes)[N]) {
  return {reinterpret_cast<const char*>(bytes), N};
}

${constants}
}  // namespace

std::optional<EmbeddedFile> ${FUNCTION}(std::string_view path) {
${cases}  return std::nullopt;
}

}  // namespace tessera
")
