# SPDX-License-Identifier: GPL-3.0-or-later
# OpenImageIO::OpenImageIO, as scripts/setup.sh put it into .deps: headers of the source package, libraries of the wheel.
# It is no official development package: pass only plain types across, and compare OIIO_VERSION with
# openimageio_version() once at run time.
if(NOT EXISTS "${TYNDALL_DEPS}/openimageio/version.txt")
    message(FATAL_ERROR "OpenImageIO is not in ${TYNDALL_DEPS}: run scripts/setup.sh")
endif()
foreach(library OpenImageIO_Util OpenImageIO)
    add_library(OpenImageIO::${library} SHARED IMPORTED)
    set_target_properties(OpenImageIO::${library} PROPERTIES
        IMPORTED_LOCATION "${TYNDALL_DEPS}/openimageio/lib/lib${library}.so"
        INTERFACE_INCLUDE_DIRECTORIES "${TYNDALL_DEPS}/openimageio/include")
endforeach()
target_link_libraries(OpenImageIO::OpenImageIO INTERFACE OpenImageIO::OpenImageIO_Util)
