# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
#
# OpenUSD from a root without a CMake package: headers in include/, libraries in lib/ (libusd_ms, or libusd_hd ... with
# any prefix). Sets pxr_FOUND, PXR_INCLUDE_DIRS, PXR_LIBRARIES, PXR_VERSION.
set(pxr_FOUND FALSE)
find_path(HDWAVEFRONT_PXR_INCLUDE_DIR pxr/imaging/hd/renderDelegate.h
          PATHS "${HDWAVEFRONT_OPENUSD_ROOT}" PATH_SUFFIXES include toolkit/include NO_DEFAULT_PATH)
mark_as_advanced(HDWAVEFRONT_PXR_INCLUDE_DIR)
if(NOT HDWAVEFRONT_PXR_INCLUDE_DIR)
  return()
endif()
file(GLOB PXR_LIBRARIES "${HDWAVEFRONT_OPENUSD_ROOT}/lib*/libusd_ms.so" "${HDWAVEFRONT_OPENUSD_ROOT}/dsolib/libusd_ms.so")
if(NOT PXR_LIBRARIES)
  foreach(library hd hdsi hio geomUtil cameraUtil plug tf gf vt sdf work pxOsd)
    file(GLOB found "${HDWAVEFRONT_OPENUSD_ROOT}/lib*/lib*_${library}.so" "${HDWAVEFRONT_OPENUSD_ROOT}/dsolib/lib*_${library}.so")
    list(APPEND PXR_LIBRARIES ${found})
  endforeach()
endif()
if(NOT PXR_LIBRARIES)
  return()
endif()
find_package(Python COMPONENTS Development.Module QUIET)
set(PXR_INCLUDE_DIRS "${HDWAVEFRONT_PXR_INCLUDE_DIR}" ${Python_INCLUDE_DIRS})
file(STRINGS "${HDWAVEFRONT_PXR_INCLUDE_DIR}/pxr/pxr.h" versionLine REGEX "define PXR_VERSION " LIMIT_COUNT 1)
string(REGEX REPLACE "^.*PXR_VERSION +([0-9]+).*$" "\\1" PXR_VERSION "${versionLine}")
set(pxr_FOUND TRUE)
