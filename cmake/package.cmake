# What `cmake --install` puts where, the Debian packages of `cpack -G DEB`, and what is in the wheel.
#
# The program and what it loads stand in one folder, since it looks for its modules beside itself;
# bin/ has a link to it. OpenImageIO, with the 260 libraries that it brings, is a package of its own:
# no worker and no coordinator needs it.
include(GNUInstallDirs)
set(programs "lib/${PROJECT_NAME}")

install(TARGETS tessera tessera-bench tessera-image-codec RUNTIME DESTINATION "${programs}" COMPONENT tessera)
install(TARGETS tessera_nlopt LIBRARY DESTINATION "${programs}" COMPONENT tessera)
if(TARGET tessera_embree)
  install(TARGETS tessera_embree LIBRARY DESTINATION "${programs}" COMPONENT tessera)
endif()
install(TARGETS tessera_oiio LIBRARY DESTINATION "${programs}" COMPONENT openimageio)
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/package/bin")
file(CREATE_LINK "../${programs}/tessera" "${CMAKE_BINARY_DIR}/package/bin/tessera" SYMBOLIC)
install(FILES "${CMAKE_BINARY_DIR}/package/bin/tessera" DESTINATION "${CMAKE_INSTALL_BINDIR}"
        COMPONENT tessera)

# A build has them where its programs look for them, too.
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/share/tessera")
file(CREATE_LINK "${CMAKE_SOURCE_DIR}/scenes/samples" "${CMAKE_BINARY_DIR}/share/tessera/samples" SYMBOLIC)
install(DIRECTORY scenes/samples DESTINATION "${CMAKE_INSTALL_DATADIR}/tessera" COMPONENT tessera
        PATTERN "*.py" EXCLUDE)
install(PROGRAMS deploy/slurm/tessera.sbatch DESTINATION "${CMAKE_INSTALL_DATADIR}/tessera"
        COMPONENT tessera)
install(FILES README.md DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT tessera)
install(DIRECTORY docs examples DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT tessera)
# What lies outside of any prefix is for the package alone.
install(DIRECTORY deploy/systemd/ DESTINATION /lib/systemd/system COMPONENT tessera EXCLUDE_FROM_ALL
        FILES_MATCHING PATTERN "*.service")
foreach(service serve worker)
  install(FILES "deploy/systemd/tessera-${service}.default" DESTINATION /etc/default
          RENAME "tessera-${service}" COMPONENT tessera EXCLUDE_FROM_ALL)
endforeach()
install(DIRECTORY DESTINATION /etc/tessera COMPONENT tessera EXCLUDE_FROM_ALL)

# Debian wants these compressed, and the same bytes from every build.
find_program(GZIP gzip REQUIRED)
function(install_compressed source name destination component)
  set(packed "${CMAKE_BINARY_DIR}/package/${component}/${name}.gz")
  add_custom_command(OUTPUT "${packed}"
    COMMAND "${CMAKE_COMMAND}" -E make_directory "${CMAKE_BINARY_DIR}/package/${component}"
    COMMAND "${GZIP}" -9nc "${CMAKE_SOURCE_DIR}/${source}" > "${packed}"
    DEPENDS "${CMAKE_SOURCE_DIR}/${source}" VERBATIM)
  string(MAKE_C_IDENTIFIER "package_${component}_${name}" target)
  add_custom_target("${target}" ALL DEPENDS "${packed}")
  install(FILES "${packed}" DESTINATION "${destination}" COMPONENT "${component}")
endfunction()
install_compressed(deploy/debian/tessera.1 tessera.1 "${CMAKE_INSTALL_MANDIR}/man1" tessera)
function(install_package_documents package component)
  set(folder "${CMAKE_INSTALL_DATADIR}/doc/${package}")
  install(FILES deploy/debian/copyright DESTINATION "${folder}" COMPONENT "${component}")
  install_compressed(deploy/debian/changelog changelog "${folder}" "${component}")
endfunction()
install_package_documents(tessera tessera)
install_package_documents(tessera-openimageio openimageio)
if(TARGET tessera_python)
  include(package_python)
endif()

# Every cpack makes the same bytes of the same files: those have the time of the changelog's last entry.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS deploy/debian/changelog)
file(STRINGS deploy/debian/changelog released REGEX "^ -- .*>  " LIMIT_COUNT 1)
string(REGEX REPLACE ".*>  " "" released "${released}")
if(NOT released)
  message(FATAL_ERROR "deploy/debian/changelog: no line ' -- NAME <ADDRESS>  DATE'")
endif()
execute_process(COMMAND date "--date=${released}" +%s OUTPUT_VARIABLE released OUTPUT_STRIP_TRAILING_WHITESPACE
                COMMAND_ERROR_IS_FATAL ANY)
set(CPACK_PROJECT_CONFIG_FILE "${CMAKE_BINARY_DIR}/package/time.cmake")
file(WRITE "${CPACK_PROJECT_CONFIG_FILE}" "if(NOT DEFINED ENV{SOURCE_DATE_EPOCH})
  set(ENV{SOURCE_DATE_EPOCH} ${released})
endif()
")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "ray-tracing renderer that spreads a frame over a farm")
set(CPACK_PACKAGE_CONTACT "The Tessera authors <tessera@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ
    GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL tessera openimageio)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_TESSERA_PACKAGE_NAME tessera)
set(CPACK_DEBIAN_TESSERA_PACKAGE_RECOMMENDS "tessera-openimageio (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_TESSERA_DESCRIPTION
"A coordinator cuts a frame into tiles and ships the scene once; workers
trace; the picture comes back the same to the last bit for any number of
workers and any pattern of failures. Reads OBJ, PLY, STL, glTF, X3D and its
own scenes; writes PNG and EXR.")
set(CPACK_DEBIAN_TESSERA_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/conffiles")
set(CPACK_DEBIAN_OPENIMAGEIO_PACKAGE_NAME tessera-openimageio)
set(CPACK_DEBIAN_OPENIMAGEIO_PACKAGE_DEPENDS "tessera (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_OPENIMAGEIO_DESCRIPTION
"With this module it writes TIFF and the like, and reads textures of all
formats of OpenImageIO. Wanted where scenes are submitted and pictures fetched.")
if(TARGET tessera_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-tessera)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "tessera (= ${PROJECT_VERSION}), python3 (>= 3.11~), python3 (<< 3.12)")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-numpy, tessera-openimageio")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-tqdm, python3-ipython")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/deploy/debian/python3/postinst"
    "${CMAKE_SOURCE_DIR}/deploy/debian/python3/prerm")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION
"This is the Python module tessera: scenes as values, and pictures and ray
queries as arrays. Worker processes of the package tessera render for it.")
include(CPack)
