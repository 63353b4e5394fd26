# Included by folders that trace rays, or touch every pixel.
# That is worth more of the compiler's time.
add_compile_options("$<$<CONFIG:Release>:-O3>")
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Which GCC 12 sees in the headers of fmt, where -O3 lets it follow more.
  add_compile_options("$<$<CONFIG:Release>:-Wno-stringop-overflow>")
endif()
# GCC 12 joins neighbouring doubles into vectors that it then reads while they are still being
# written by halves: slower, and what we trace is mostly such code. Nobody replaces our functions.
add_compile_options(-fno-tree-slp-vectorize -fno-semantic-interposition)
# The same of copies: by words, as they were written; and by plain stores where they are short, since
# string instructions take long to begin. What ships is worth the odd switch.
include(CheckCXXCompilerFlag)
set(stores "unrolled_loop:512:noalign,libcall:-1:noalign")
foreach(switch "tune-ctrl=^sse_unaligned_load_optimal,^sse_unaligned_store_optimal"
        "memset-strategy=${stores}" "memcpy-strategy=${stores}")
  string(MAKE_C_IDENTIFIER "TESSERA_HAS_${switch}" has)
  check_cxx_compiler_flag("-m${switch}" ${has})
  if(${has})
    add_compile_options("$<$<CONFIG:Release>:-m${switch}>")
  endif()
endforeach()
