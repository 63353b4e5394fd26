# Compiler settings and the one function by which every folder becomes a target.

include(embed)

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()

option(TESSERA_WERROR "Treat warnings as errors" OFF)
option(TESSERA_FUZZ "Build the libFuzzer targets (needs Clang)" OFF)
set(TESSERA_SANITIZE "" CACHE STRING "Comma-separated sanitizers for the whole build")

# What was compiled once, in any folder of this machine, is not compiled again: paths below the source
# folder go into the cache's key as seen from the build folder.
foreach(tool CCACHE MOLD)  # what a cache still names may have been removed since
  if(${tool} AND NOT EXISTS "${${tool}}")
    unset(${tool} CACHE)
  endif()
endforeach()
find_program(CCACHE ccache)
if(CCACHE)
  # By its inode cache each header is hashed once for all sources, which makes hits four times as fast.
  set(CMAKE_CXX_COMPILER_LAUNCHER "${CMAKE_COMMAND}" -E env "CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}" CCACHE_NOHASHDIR=1
      CCACHE_INODECACHE=1 CCACHE_SLOPPINESS=time_macros,include_file_mtime,include_file_ctime "${CCACHE}")
endif()

find_program(MOLD mold)
if(MOLD AND NOT TESSERA_SANITIZE)
  add_link_options(-fuse-ld=mold)
endif()

add_library(tessera_flags INTERFACE)
target_include_directories(tessera_flags INTERFACE "${CMAKE_SOURCE_DIR}")
# Who builds to use it is spared the warnings: GCC 12 at -O3 gives some for nothing.
set(warnings)
if(TESSERA_WERROR)
  set(warnings -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Wvla)
endif()
# Contraction would let the compiler choose where a multiply-add rounds once, so that two builds
# would render different bits. Errno and FP traps are never read; giving them up changes no result.
target_compile_options(tessera_flags INTERFACE ${warnings}
  "-ffile-prefix-map=${CMAKE_SOURCE_DIR}/="
  -ffp-contract=off -fno-math-errno -fno-trapping-math)
# The libraries' assertions stay on: they cost nothing that could be measured.
set(CMAKE_CXX_FLAGS_RELEASE "-O2")
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1 -fno-omit-frame-pointer")
if(TESSERA_WERROR)
  target_compile_options(tessera_flags INTERFACE -Werror)
endif()
# Generated code too is held against these.
add_library(tessera_sanitizers INTERFACE)
if(TESSERA_SANITIZE)
  # Not vptr: it opens a pipe for each look, and calls an object false where tests leave no
  # descriptor.
  target_compile_options(tessera_sanitizers INTERFACE -fsanitize=${TESSERA_SANITIZE}
                         -fno-sanitize=vptr -fno-sanitize-recover=all)
  target_link_options(tessera_sanitizers INTERFACE -fsanitize=${TESSERA_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # Found where nothing is uninitialized, since GCC's optimizer sees less through the checks (its
    # manual warns of this at -fsanitize); the other builds keep this warning.
    target_compile_options(tessera_sanitizers INTERFACE -Wno-maybe-uninitialized)
  endif()
endif()
target_link_libraries(tessera_flags INTERFACE tessera_sanitizers)
if(TESSERA_FUZZ)
  target_compile_options(tessera_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# tessera_module(PATH [USES module...] [LINKS target...])
#   Makes the folder PATH (from the repository's root) a library of every .cpp file in it; with no
#   .cpp it is header-only. USES names the modules whose headers it may include: its allowed dependencies,
#   written to modules.txt and held against the #include lines by tests/architecture. LINKS names
#   libraries from outside.
function(tessera_module path)
  cmake_parse_arguments(MODULE "" "" "USES;LINKS" ${ARGN})
  string(REPLACE "/" "_" target "${path}")
  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_SOURCE_DIR}/${path}/*.cpp")
  list(FILTER sources EXCLUDE REGEX "_main\\.cpp$")
  if(sources)
    set(scope PUBLIC)
    add_library(${target} STATIC ${sources})
  else()
    set(scope INTERFACE)
    add_library(${target} INTERFACE)
  endif()
  # Of what is compiled together a compiler inlines less well, which costs tracing up to 4 %.
  if(path MATCHES "^(renderer|query)" AND NOT path STREQUAL "renderer/scene" AND CMAKE_BUILD_TYPE STREQUAL "Release")
    set_target_properties(${target} PROPERTIES UNITY_BUILD OFF)
  endif()
  # These wait for people and sockets: compiling them is worth less time than what traces and reads scenes. Where GCC 12
  # looks less closely, it takes more for uninitialized.
  set(unhurried "web|studio|bench/studio|front|cli|coordinator/web|scenes/edit")
  if(TESSERA_SANITIZE)
    string(APPEND unhurried "|python")
  endif()
  if(sources AND path MATCHES "^(${unhurried})(/|$)" AND (CMAKE_BUILD_TYPE STREQUAL "Release" OR TESSERA_SANITIZE))
    target_compile_options(${target} PRIVATE -O1 "$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>")
  endif()
  string(REPLACE "/" "_" uses "${MODULE_USES}")
  target_link_libraries(${target} ${scope} tessera_flags ${uses} ${MODULE_LINKS})
  tessera_declare_module("${path}" ${MODULE_USES})
endfunction()

# tessera_declare_module(PATH module...): names a module and its dependencies, also where nothing of it is built.
function(tessera_declare_module path)
  list(JOIN ARGN " " uses)
  set_property(GLOBAL APPEND PROPERTY TESSERA_MODULES "${path}: ${uses}")
endfunction()

# tessera_program(NAME MAIN [USES module...] [LINKS target...]): one executable from one _main.cpp.
function(tessera_program name main)
  cmake_parse_arguments(PROGRAM "" "" "USES;LINKS" ${ARGN})
  add_executable(${name} "${main}")
  string(REPLACE "/" "_" uses "${PROGRAM_USES}")
  target_link_libraries(${name} PRIVATE tessera_flags ${uses} ${PROGRAM_LINKS})
endfunction()

function(tessera_write_modules file)
  get_property(modules GLOBAL PROPERTY TESSERA_MODULES)
  string(REPLACE ";" "\n" text "${modules}")
  file(WRITE "${file}" "${text}\n")
endfunction()
