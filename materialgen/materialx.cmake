# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
#
# MaterialX Core and Format from the source distribution on PyPI (no distribution packages the C++ libraries with the
# data libraries that we need). We compile the two folders ourselves: their own build wants a newer CMake, and options
# for a dozen modules that we leave out. Target: materialx. Sets HDWAVEFRONT_MATERIALX_LIBRARIES, the data libraries.
set(HDWAVEFRONT_MATERIALX_VERSION 1.39.5)
set(materialxSha256 e6d4da032bce6fd782ec91fe898866b80cf988103c7d70e7d530404f45f5644c)

# Shared by all build folders of this checkout; a read-only checkout keeps it in its build folder.
set(materialxCache "${PROJECT_SOURCE_DIR}/build/third_party")
execute_process(COMMAND mkdir -p "${materialxCache}" RESULT_VARIABLE materialxCacheMissing ERROR_QUIET)
execute_process(COMMAND test -w "${materialxCache}" RESULT_VARIABLE materialxCacheReadOnly)
if(materialxCacheMissing OR materialxCacheReadOnly OR EXISTS "${PROJECT_BINARY_DIR}/third_party/materialx.lock")
  set(materialxCache "${PROJECT_BINARY_DIR}/third_party")
  file(MAKE_DIRECTORY "${materialxCache}")
endif()

# Sets `archive` to the source distribution's path, downloading it by pip where it is not there yet.
function(hdwavefront_download_materialx archive)
  set(file "${materialxCache}/materialx-${HDWAVEFRONT_MATERIALX_VERSION}.tar.gz")
  if(NOT EXISTS "${file}")
    find_program(HDWAVEFRONT_PIP_PYTHON NAMES python3 python
                 HINTS "${PROJECT_SOURCE_DIR}/.venv/bin" NO_CACHE)
    if(DEFINED Python_EXECUTABLE)
      set(HDWAVEFRONT_PIP_PYTHON "${Python_EXECUTABLE}")
    endif()
    message(STATUS "Downloading MaterialX ${HDWAVEFRONT_MATERIALX_VERSION} (source distribution, 9 MB)")
    execute_process(
      COMMAND "${HDWAVEFRONT_PIP_PYTHON}" -m pip download --quiet --no-deps --no-binary MaterialX
              --dest "${materialxCache}/download" "MaterialX==${HDWAVEFRONT_MATERIALX_VERSION}"
      RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    file(GLOB downloaded "${materialxCache}/download/*.tar.gz")
    if(NOT result EQUAL 0 OR NOT downloaded)
      message(FATAL_ERROR
        "MaterialX ${HDWAVEFRONT_MATERIALX_VERSION} could not be downloaded: pip, run by "
        "${HDWAVEFRONT_PIP_PYTHON}, said:\n${output}\nGet the source distribution of MaterialX by other means and "
        "configure with -DHDWAVEFRONT_MATERIALX=<its .tar.gz or its unpacked folder>.")
    endif()
    list(GET downloaded 0 downloaded)
    file(SHA256 "${downloaded}" hash)
    if(NOT hash STREQUAL materialxSha256)
      file(REMOVE_RECURSE "${materialxCache}/download")
      message(FATAL_ERROR "MaterialX's source distribution has the wrong SHA-256: ${hash}, not ${materialxSha256}.")
    endif()
    file(RENAME "${downloaded}" "${file}")
    file(REMOVE_RECURSE "${materialxCache}/download")
  endif()
  set(${archive} "${file}" PARENT_SCOPE)
endfunction()

# Sets `folder` to an unpacked source tree. Two configurations at once wait for each other.
function(hdwavefront_find_materialx folder)
  if(HDWAVEFRONT_MATERIALX AND IS_DIRECTORY "${HDWAVEFRONT_MATERIALX}")
    set(${folder} "${HDWAVEFRONT_MATERIALX}" PARENT_SCOPE)
    return()
  endif()
  file(LOCK "${materialxCache}/materialx.lock" GUARD FUNCTION)
  set(unpacked "${materialxCache}/materialx-${HDWAVEFRONT_MATERIALX_VERSION}")
  if(HDWAVEFRONT_MATERIALX)
    file(REMOVE_RECURSE "${unpacked}")
    set(archive "${HDWAVEFRONT_MATERIALX}")
  elseif(NOT EXISTS "${unpacked}/source/MaterialXCore/Document.cpp")
    hdwavefront_download_materialx(archive)
  endif()
  if(DEFINED archive)
    # Unpacked beside and renamed, so that an interrupted run leaves no half of a tree.
    file(REMOVE_RECURSE "${unpacked}" "${materialxCache}/unpack")
    file(ARCHIVE_EXTRACT INPUT "${archive}" DESTINATION "${materialxCache}/unpack")
    file(RENAME "${materialxCache}/unpack/materialx-${HDWAVEFRONT_MATERIALX_VERSION}" "${unpacked}")
    file(REMOVE_RECURSE "${materialxCache}/unpack")
  endif()
  set(${folder} "${unpacked}" PARENT_SCOPE)
endfunction()

hdwavefront_find_materialx(materialxRoot)
set(materialxSource "${materialxRoot}/source")
if(NOT EXISTS "${materialxSource}/MaterialXCore/Document.cpp")
  message(FATAL_ERROR "${materialxRoot} is not a MaterialX source tree (no source/MaterialXCore).")
endif()
set(HDWAVEFRONT_MATERIALX_LIBRARIES "${materialxRoot}/libraries" CACHE INTERNAL "MaterialX's data libraries")

string(REPLACE "." ";" materialxVersionList "${HDWAVEFRONT_MATERIALX_VERSION}")
list(GET materialxVersionList 0 MATERIALX_MAJOR_VERSION)
list(GET materialxVersionList 1 MATERIALX_MINOR_VERSION)
list(GET materialxVersionList 2 MATERIALX_BUILD_VERSION)
set(MATERIALX_NAMESPACE "MaterialX_v1_39_5")
configure_file("${materialxSource}/MaterialXCore/Generated.h.in"
               "${CMAKE_CURRENT_BINARY_DIR}/materialx/MaterialXCore/Generated.h")

file(GLOB materialxSources "${materialxSource}/MaterialXCore/*.cpp" "${materialxSource}/MaterialXFormat/*.cpp"
     "${materialxSource}/MaterialXFormat/External/PugiXML/*.cpp")
add_library(materialx STATIC ${materialxSources})
target_include_directories(materialx SYSTEM PUBLIC "${materialxSource}" "${CMAKE_CURRENT_BINARY_DIR}/materialx")
target_compile_options(materialx PRIVATE -w)
target_link_libraries(materialx PUBLIC ${CMAKE_DL_LIBS})
