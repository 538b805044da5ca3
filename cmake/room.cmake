# SPDX-License-Identifier: GPL-3.0-or-later
# What every target of ours is compiled with. The baseline is x86-64-v2; hot kernels dispatch above it (core/simd.hpp).
add_library(tyndall_options INTERFACE)
target_compile_options(tyndall_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow=local -Werror -march=x86-64-v2
    -fno-math-errno -ffp-contract=off)
target_include_directories(tyndall_options INTERFACE "${CMAKE_SOURCE_DIR}/native")
# GLM's experimental headers stay off; its warnings are not ours.
target_compile_definitions(tyndall_options INTERFACE GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_XYZW_ONLY)

# Sixteen files are compiled as one: headers cost more than what stands below them. So helpers of a file are named as if those
# of its neighbours were in sight; tests have a namespace per file. With -DTYNDALL_UNITY=OFF each file stands alone.
# Left alone: what Highway compiles once per instruction set, and what replaces the allocator.
function(tyndall_unity target)
    if(NOT TYNDALL_UNITY)
        return()
    endif()
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 16)
    get_target_property(sources ${target} SOURCES)
    foreach(source ${sources})
        get_filename_component(file "${source}" ABSOLUTE)
        file(STRINGS "${file}" alone REGEX "hwy/foreach_target.h|void\\* operator new" LIMIT_COUNT 1)
        if(alone)
            set_source_files_properties("${source}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
        endif()
    endforeach()
endfunction()

# tyndall_room(NAME LINKS a b ...): a static library from all .cpp files of the current folder. What lies deeper
# is a library of its own.
function(tyndall_room name)
    cmake_parse_arguments(ROOM "" "" "LINKS" ${ARGN})
    file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/*.cpp")
    if(sources)
        add_library(tyndall_${name} STATIC ${sources})
        target_link_libraries(tyndall_${name} PUBLIC tyndall_options ${ROOM_LINKS})
        tyndall_unity(tyndall_${name})
    else()
        add_library(tyndall_${name} INTERFACE)
        target_link_libraries(tyndall_${name} INTERFACE tyndall_options ${ROOM_LINKS})
    endif()
endfunction()
