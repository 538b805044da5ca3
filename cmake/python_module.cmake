# SPDX-License-Identifier: GPL-3.0-or-later
# tyndall_python_module(NAME SOURCES a.cpp ... LINKS a b ...): the native module tyndall.NAME. A development build lies in
# build/<preset>/python/tyndall, which PYTHONPATH names beside python/; a wheel has it in tyndall/.
execute_process(COMMAND "${TYNDALL_DEPS}/build/bin/python" -m pybind11 --cmakedir
    OUTPUT_VARIABLE pybind11_DIR OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(PYBIND11_FINDPYTHON ON)
if(NOT Python_EXECUTABLE)
    set(Python_EXECUTABLE "${TYNDALL_DEPS}/build/bin/python")
endif()
find_package(pybind11 3.1 CONFIG REQUIRED)

function(tyndall_python_module name)
    cmake_parse_arguments(MODULE "" "" "SOURCES;LINKS" ${ARGN})
    # No extras: link-time optimisation gains nothing over rooms that are static libraries, and costs link time.
    pybind11_add_module(${name} MODULE NO_EXTRAS ${MODULE_SOURCES})
    target_link_libraries(${name} PRIVATE ${MODULE_LINKS})
    # Nothing is computed in a binding, and a third of the time that it takes to compile is optimising.
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
    # Blender holds other copies of the libraries that we link: nothing of ours may be found there by name but the entry.
    set(exports "${CMAKE_SOURCE_DIR}/cmake/python_module.map")
    target_link_options(${name} PRIVATE "LINKER:--version-script=${exports}")
    set_target_properties(${name} PROPERTIES
        LINK_DEPENDS "${exports}"
        LIBRARY_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/python/tyndall")
    install(TARGETS ${name} LIBRARY DESTINATION tyndall)
    if(NOT SKBUILD)
        # Types for mypy and editors: a product of the build, not committed.
        add_custom_command(TARGET ${name} POST_BUILD COMMENT "Stubs of ${name}" VERBATIM
            COMMAND "${CMAKE_COMMAND}" -E env "PYTHONPATH=${CMAKE_BINARY_DIR}/python:${CMAKE_SOURCE_DIR}/python"
                "${TYNDALL_DEPS}/build/bin/stubgen" -q --include-docstrings -m tyndall.${name} -o "${CMAKE_SOURCE_DIR}/python")
    endif()
endfunction()
