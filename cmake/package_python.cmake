# The Python package is installed twice: for Debian, whose package `tessera` has the program, and as the
# contents of a wheel (setup.py), which has a program of its own.

# install_python_package(FOLDER COMPONENT...): the module, and its Python files. In the build folder
# those are links into python/, or generated.
function(install_python_package folder)
  install(TARGETS tessera_python LIBRARY DESTINATION "${folder}" COMPONENT ${ARGN})
  install(CODE "
    cmake_policy(SET CMP0009 NEW)  # links to folders are not followed
    set(package \"${CMAKE_BINARY_DIR}/python/tessera\")
    file(GLOB_RECURSE files RELATIVE \"\${package}\"
         \"\${package}/*.py\" \"\${package}/*.pyi\" \"\${package}/py.typed\")
    foreach(file IN LISTS files)
      file(REAL_PATH \"\${package}/\${file}\" source)
      get_filename_component(folder \"\${CMAKE_INSTALL_PREFIX}/${folder}/\${file}\" DIRECTORY)
      file(INSTALL \"\${source}\" DESTINATION \"\${folder}\")
    endforeach()" COMPONENT ${ARGN})
endfunction()

install_python_package(lib/python3/dist-packages/tessera python)
install_package_documents(python3-tessera python)

install_python_package(tessera wheel EXCLUDE_FROM_ALL)
set(programs tessera tessera-bench tessera-image-codec)
set(modules tessera_nlopt tessera_oiio)
if(TARGET tessera_embree)
  list(APPEND modules tessera_embree)
endif()
install(TARGETS ${programs} ${modules} DESTINATION tessera/_bin COMPONENT wheel EXCLUDE_FROM_ALL)
add_custom_target(wheel DEPENDS tessera_python ${programs} ${modules})
