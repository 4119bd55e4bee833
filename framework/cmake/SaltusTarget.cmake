# Declaration of targets: language level, flags for users, and flags for our own objects.
#
#   saltus_usage           flags for users' objects and our own; installed with the libraries
#   saltus_sanitizers      flags of the sanitizers for every object, if enabled
#   saltus_position_independent  flags of objects that can become part of a shared library
#   saltus_baseline_flags  our own objects: warnings, sanitizers
#   saltus_flags           our own objects: also the instruction set and optimisation
#   saltus_program_flags   our own programs: link options

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
if(PROJECT_IS_TOP_LEVEL)
  set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
  if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug, RelWithDebInfo" FORCE)
  endif()
endif()

set(SALTUS_MARCH "" CACHE STRING "Value of -march for the numerical code; empty is portable")
option(SALTUS_WERROR "Treat warnings as errors" OFF)
set(SALTUS_SANITIZE OFF CACHE STRING "ON: address and undefined-behaviour sanitizers; thread: of data races")
option(SALTUS_FUZZ "Count branches for libFuzzer, and build saltus_fuzz; needs clang" OFF)

# ---- flags for users' objects ---------------------------------------------------------------------

include(GNUInstallDirs)
include(saltusPlugin) # saltus_plugin(), also for users
include(saltusCasadi) # saltus_casadi(), also for users
add_library(saltus_usage INTERFACE)
set_target_properties(saltus_usage PROPERTIES EXPORT_NAME usage)
add_library(saltus::usage ALIAS saltus_usage)
target_compile_features(saltus_usage INTERFACE cxx_std_20)
# Include roots: <saltus/ocp/phase.hpp> is framework/saltus/ocp/phase.hpp here, and include/saltus/ocp/phase.hpp
# in an installation.
set(SALTUS_INCLUDE_ROOTS ${PROJECT_SOURCE_DIR}/framework ${PROJECT_SOURCE_DIR}/integrators
                         ${PROJECT_SOURCE_DIR}/robots)
target_include_directories(saltus_usage INTERFACE "$<BUILD_INTERFACE:${SALTUS_INCLUDE_ROOTS}>"
                                                  $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
# Creates headers at the old paths of moved headers (moved_headers.txt), for projects that contain
# Saltus.
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/framework/cmake/moved_headers.txt)
file(STRINGS ${PROJECT_SOURCE_DIR}/framework/cmake/moved_headers.txt SALTUS_MOVED_HEADERS REGEX "^[a-z]")
set(SALTUS_MOVED_HEADERS_DIR ${PROJECT_BINARY_DIR}/moved_headers)
foreach(line ${SALTUS_MOVED_HEADERS})
  string(REGEX MATCH "^[a-z]+ ([^ ]+) ([^ ]+)$" line "${line}")
  set(old ${CMAKE_MATCH_1})
  set(new ${CMAKE_MATCH_2})
  file(CONFIGURE OUTPUT ${SALTUS_MOVED_HEADERS_DIR}/saltus/${old} @ONLY
       CONTENT "// Moved: include <saltus/@new@>. This header is removed in 0.4.\n#pragma once\n#include <saltus/@new@>\n")
endforeach()
if(NOT PROJECT_IS_TOP_LEVEL)
  target_include_directories(saltus_usage INTERFACE "$<BUILD_INTERFACE:${SALTUS_MOVED_HEADERS_DIR}>")
endif()
# Packaged libraries (DART) are built for 16-byte alignment. The same limit everywhere keeps the
# layout of Eigen types compatible for every -march.
target_compile_definitions(saltus_usage INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
# Eigen must free memory in the same way as it allocated it. The way depends on the width of
# vectors. Users of an installed library must therefore compile for the processor that it was built
# for; core/types.hpp rejects others.
set(SALTUS_EIGEN_ALIGN_BYTES 16)
if(SALTUS_MARCH)
  include(CheckCXXSourceCompiles)
  set(CMAKE_REQUIRED_FLAGS "-march=${SALTUS_MARCH}")
  check_cxx_source_compiles("#ifndef __AVX__\n#error\n#endif\nint main() {}" SALTUS_MARCH_${SALTUS_MARCH}_HAS_AVX)
  check_cxx_source_compiles("#ifndef __AVX512F__\n#error\n#endif\nint main() {}" SALTUS_MARCH_${SALTUS_MARCH}_HAS_AVX512)
  unset(CMAKE_REQUIRED_FLAGS)
  if(SALTUS_MARCH_${SALTUS_MARCH}_HAS_AVX512)
    set(SALTUS_EIGEN_ALIGN_BYTES 64)
  elseif(SALTUS_MARCH_${SALTUS_MARCH}_HAS_AVX)
    set(SALTUS_EIGEN_ALIGN_BYTES 32)
  endif()
  target_compile_options(saltus_usage INTERFACE $<INSTALL_INTERFACE:-march=${SALTUS_MARCH}>)
endif()
target_compile_definitions(saltus_usage INTERFACE
                           $<INSTALL_INTERFACE:SALTUS_EIGEN_ALIGN_BYTES=${SALTUS_EIGEN_ALIGN_BYTES}>)
# With AVX-512, gcc 12 miscompiles a wide constant such as {1, 1, 0, 0} if it is stored at once: it
# broadcasts the first half, so {exactly(1), exactly(0)} became [1, 1] twice. Pieces of 16 bytes, as
# without -march, avoid this and do not affect vector loops.
include(CheckCXXCompilerFlag)
check_cxx_compiler_flag(-mmove-max=128 SALTUS_HAS_MOVE_MAX)
if(SALTUS_HAS_MOVE_MAX)
  target_compile_options(saltus_usage INTERFACE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:$<$<VERSION_GREATER_EQUAL:$<CXX_COMPILER_VERSION>,12>:-mmove-max=128;-mstore-max=128>>")
endif()

# ---- our own objects -------------------------------------------------------------------------------

add_library(saltus_baseline_flags INTERFACE)
add_library(saltus_flags INTERFACE)
add_library(saltus_sanitizers INTERFACE)
add_library(saltus_position_independent INTERFACE)
# Static libraries, too, can be linked into a shared library: a plugin, or an extension of Python. Without semantic
# interposition the compiler inlines as in a program, so solves keep their bits and their instructions. Programs use the
# same flags, because precompiled headers contain them.
target_compile_options(saltus_position_independent INTERFACE -fPIC -fno-semantic-interposition)
target_link_libraries(saltus_baseline_flags INTERFACE saltus_usage saltus_sanitizers saltus_position_independent)
target_link_libraries(saltus_flags INTERFACE saltus_baseline_flags)
target_compile_options(saltus_baseline_flags INTERFACE
                       -Wall -Wextra -Wshadow -Wnon-virtual-dtor
                       $<$<BOOL:${SALTUS_WERROR}>:-Werror>)
if(SALTUS_MARCH)
  target_compile_options(saltus_flags INTERFACE -march=${SALTUS_MARCH})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # With wide vectors gcc warns about its own intrinsics (undefined registers, GCC bug 105593) and
    # about vector loops of Eigen that small matrices never enter. Portable builds still report
    # these warnings.
    target_compile_options(saltus_flags INTERFACE -Wno-maybe-uninitialized -Wno-uninitialized
                                                  -Wno-array-bounds
                                                  -Wno-stringop-overflow -Wno-stringop-overread)
  endif()
endif()
if(SALTUS_SANITIZE)
  set(SALTUS_SANITIZERS address,undefined)
  if(SALTUS_SANITIZE STREQUAL "thread")
    set(SALTUS_SANITIZERS thread)
  endif()
  target_compile_options(saltus_sanitizers INTERFACE -fsanitize=${SALTUS_SANITIZERS}
                                            -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_compile_definitions(saltus_sanitizers INTERFACE _GLIBCXX_ASSERTIONS)
  target_link_options(saltus_sanitizers INTERFACE -fsanitize=${SALTUS_SANITIZERS})
  target_link_options(saltus_usage INTERFACE $<BUILD_INTERFACE:-fsanitize=${SALTUS_SANITIZERS}>)
endif()
if(SALTUS_FUZZ)
  target_compile_options(saltus_baseline_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
# Targets that are not libraries (problems, tests, benchmarks) also include by the path from the top
# folder.
add_library(saltus_inside INTERFACE)
target_include_directories(saltus_inside INTERFACE ${PROJECT_SOURCE_DIR})

# Programs export no symbols: a shared library would otherwise use their instances of Eigen's inline
# functions, built for another processor, instead of its own. A linked-in sanitizer must export its
# malloc and free, or a shared library frees memory that it has not allocated.
add_library(saltus_program_flags INTERFACE)
if(NOT SALTUS_SANITIZE)
  target_link_options(saltus_program_flags INTERFACE
                      -Wl,--exclude-libs,ALL
                      -Wl,--version-script=${PROJECT_SOURCE_DIR}/framework/cmake/nothing_exported.map)
endif()

# ---- precompiled headers -------------------------------------------------------------------------

# The third-party headers of nearly every object take two to three seconds to parse. The precompiled
# headers contain none of our own, so that our changes never rebuild everything. Sources must not
# rely on them: users have none, and a test compiles each public header alone.
option(SALTUS_PRECOMPILED_HEADERS "Parse the headers of Eigen, fmt and the standard library once"
       ${PROJECT_IS_TOP_LEVEL})

# saltus_parsed_once(NAME DEPENDS ... HEADERS ...): precompiled headers for targets with the same
# flags.
function(saltus_parsed_once name)
  cmake_parse_arguments(H "" "" "DEPENDS;HEADERS" ${ARGN})
  if(SALTUS_PRECOMPILED_HEADERS)
    file(WRITE ${PROJECT_BINARY_DIR}/${name}.cpp.new "// Only the precompiled headers are of use.\n")
    configure_file(${PROJECT_BINARY_DIR}/${name}.cpp.new ${PROJECT_BINARY_DIR}/${name}.cpp COPYONLY)
    add_library(${name} OBJECT ${PROJECT_BINARY_DIR}/${name}.cpp)
    target_link_libraries(${name} PRIVATE saltus_flags ${H_DEPENDS})
    target_precompile_headers(${name} PRIVATE ${H_HEADERS})
    # A compiler cache returns the precompiled headers of an earlier build folder, whose files were
    # older. clang rejects them unless it ignores file times. ninja rebuilds them if a header has
    # changed.
    target_compile_options(${name} PRIVATE "$<$<CXX_COMPILER_ID:Clang,AppleClang>:SHELL:-Xclang -fno-pch-timestamp>")
  endif()
endfunction()
set(SALTUS_COMMON_HEADERS
    <Eigen/Core> <Eigen/Geometry> <fmt/format.h>
    <algorithm> <array> <chrono> <cmath> <cstdint> <cstdio> <filesystem> <fstream> <functional> <limits>
    <map> <memory> <numbers> <numeric> <optional> <set> <span> <sstream> <string> <string_view>
    <utility> <variant> <vector>)
saltus_parsed_once(saltus_common_headers DEPENDS Eigen3::Eigen fmt::fmt HEADERS ${SALTUS_COMMON_HEADERS})

# saltus_reuse(TARGET NAME): the target TARGET uses the precompiled headers of NAME. Both need the
# same optimisation level, because gcc's precompiled headers contain it.
function(saltus_reuse target name)
  if(TARGET ${name})
    target_precompile_headers(${target} REUSE_FROM ${name})
  endif()
endfunction()

# ---- declaration of targets ----------------------------------------------------------------------

# Components with several layers; every other component is a layer of the same name.
foreach(component core robots legged)
  if(SALTUS_HAS_${component})
    add_library(saltus_component_${component} INTERFACE)
    add_library(saltus::${component} ALIAS saltus_component_${component})
    set_target_properties(saltus_component_${component} PROPERTIES EXPORT_NAME ${component})
  endif()
endforeach()

# saltus_layer(NAME [COMPONENT core] [SOURCES a.cpp ...] [DEPENDS saltus::common ...]
#              [PRIVATE_DEPENDS ...] [FOR_PROGRAMS])
# declares the library saltus_NAME with the alias saltus::NAME; without sources, a header-only
# library. With COMPONENT it belongs to that component: it is installed with it, and not built if the
# component is disabled. A layer names the layers that it needs, never its own component.
# The library is static, or shared if BUILD_SHARED_LIBS is on and it belongs to a component. A library FOR_PROGRAMS is
# always static.
function(saltus_layer name)
  cmake_parse_arguments(LAYER "FOR_PROGRAMS" "COMPONENT" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  if(LAYER_COMPONENT AND NOT SALTUS_HAS_${LAYER_COMPONENT})
    return()
  endif()
  if(LAYER_SOURCES)
    if(BUILD_SHARED_LIBS AND LAYER_COMPONENT AND NOT LAYER_FOR_PROGRAMS)
      add_library(saltus_${name} SHARED ${LAYER_SOURCES})
      saltus_shared(saltus_${name})
    else()
      add_library(saltus_${name} STATIC ${LAYER_SOURCES})
    endif()
    target_link_libraries(saltus_${name} PUBLIC saltus_usage ${LAYER_DEPENDS}
                                         PRIVATE $<BUILD_INTERFACE:saltus_flags> ${LAYER_PRIVATE_DEPENDS})
    saltus_reuse(saltus_${name} saltus_common_headers)
  else()
    add_library(saltus_${name} INTERFACE)
    target_link_libraries(saltus_${name} INTERFACE saltus_usage ${LAYER_DEPENDS})
  endif()
  add_library(saltus::${name} ALIAS saltus_${name})
  set_target_properties(saltus_${name} PROPERTIES EXPORT_NAME ${name})
  if(LAYER_COMPONENT)
    saltus_in_component(saltus_${name} ${LAYER_COMPONENT})
  endif()
endfunction()

# saltus_shared(TARGET): properties of a shared library. Its objects are those of the static library. It has no
# undefined symbols, and finds the others in its own folder.
function(saltus_shared target)
  set_target_properties(${target} PROPERTIES
    POSITION_INDEPENDENT_CODE OFF # saltus_position_independent has the flag
    DEFINE_SYMBOL ""
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
    INSTALL_RPATH "$ORIGIN")
  if(NOT SALTUS_SANITIZE) # clang links the sanitizers into programs only
    set(symbols ${PROJECT_SOURCE_DIR}/framework/cmake/saltus_only.map)
    target_link_options(${target} PRIVATE -Wl,-z,defs -Wl,--version-script=${symbols})
    set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${symbols})
  endif()
endfunction()

# Adds a target to a component.
function(saltus_in_component target component)
  if(TARGET saltus_component_${component})
    target_link_libraries(saltus_component_${component} INTERFACE ${target})
  endif()
  set_property(GLOBAL APPEND PROPERTY SALTUS_TARGETS_${component} ${target})
endfunction()

# saltus_program(NAME SOURCES ... DEPENDS ...): an executable of our own.
function(saltus_program name)
  cmake_parse_arguments(P "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(${name} ${P_SOURCES})
  # Eigen and fmt for all programs: precompiled headers require the same definitions.
  target_link_libraries(${name} PRIVATE saltus_flags saltus_program_flags ${P_DEPENDS} Eigen3::Eigen fmt::fmt)
  saltus_reuse(${name} saltus_common_headers)
endfunction()

# saltus_install_program(NAME): the program finds the shared libraries installed with it.
function(saltus_install_program name)
  if(NOT CMAKE_INSTALL_PREFIX STREQUAL "/usr") # libraries in /usr are found anyway
    file(RELATIVE_PATH to_libraries ${CMAKE_INSTALL_FULL_BINDIR} ${CMAKE_INSTALL_FULL_LIBDIR})
    set_target_properties(${name} PROPERTIES INSTALL_RPATH "$ORIGIN/${to_libraries}")
  endif()
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
endfunction()

# saltus_data(PATH): a file or folder that programs read at run time by data_file("PATH")
# (core/data_file.hpp). The build folder links it below share/saltus; an installation copies it
# there.
function(saltus_data path)
  get_filename_component(folder ${path} DIRECTORY)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/share/saltus/${folder})
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${path} ${PROJECT_BINARY_DIR}/share/saltus/${path} SYMBOLIC)
  if(IS_DIRECTORY ${PROJECT_SOURCE_DIR}/${path})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/${path} DESTINATION ${CMAKE_INSTALL_DATADIR}/saltus/${folder}
            COMPONENT program PATTERN __pycache__ EXCLUDE)
  else()
    install(PROGRAMS ${PROJECT_SOURCE_DIR}/${path} DESTINATION ${CMAKE_INSTALL_DATADIR}/saltus/${folder}
            COMPONENT program)
  endif()
endfunction()

# saltus_compiled_fast(TARGET): for code whose speed does not matter; compiles a third faster.
# -fexpensive-optimizations keeps multiplications and additions fused as elsewhere. Do not use it
# for libraries with matrices: the linker keeps either instance of an inline function that two
# objects contain. At -O1 gcc 12 reports Eigen's realloc as a use after free.
function(saltus_compiled_fast target)
  target_compile_options(${target} PRIVATE
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-O1;-fexpensive-optimizations;-Wno-use-after-free>)
  saltus_checked_fast(${target})
endfunction()

# saltus_checked_fast(TARGET): disables optimisation under clang's sanitizers, which reduces the
# compile time to 41 %. It has no effect in folders that set SALTUS_TESTS_COMPUTE.
function(saltus_checked_fast target)
  if(NOT SALTUS_TESTS_COMPUTE)
    target_compile_options(${target} PRIVATE $<$<AND:$<CXX_COMPILER_ID:Clang>,$<BOOL:${SALTUS_SANITIZE}>>:-O0>)
  endif()
endfunction()

# saltus_test_headers(NAME DEPENDS ... HEADERS ...): precompiled headers of tests.
function(saltus_test_headers name)
  cmake_parse_arguments(H "" "" "DEPENDS;HEADERS" ${ARGN})
  saltus_parsed_once(${name} DEPENDS Eigen3::Eigen fmt::fmt GTest::gtest ${H_DEPENDS}
                     HEADERS ${SALTUS_COMMON_HEADERS} <gtest/gtest.h> ${H_HEADERS})
  if(TARGET ${name}) # gcc takes the optimisation level from the precompiled headers, not from the command
    saltus_compiled_fast(${name})
  endif()
endfunction()

# saltus_test_library(NAME SOURCES ... DEPENDS ... [PRIVATE_DEPENDS ...]): saltus::NAME, a library
# shared by several tests, with the headers that SALTUS_TEST_HEADERS names.
function(saltus_test_library name)
  cmake_parse_arguments(T "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(saltus_${name} STATIC ${T_SOURCES})
  target_link_libraries(saltus_${name} PUBLIC ${T_DEPENDS} GTest::gtest
                        PRIVATE saltus_flags ${T_PRIVATE_DEPENDS} Eigen3::Eigen fmt::fmt)
  add_library(saltus::${name} ALIAS saltus_${name})
  saltus_reuse(saltus_${name} ${SALTUS_TEST_HEADERS})
  saltus_compiled_fast(saltus_${name})
endfunction()

# saltus_test(NAME SOURCES ... DEPENDS ...): a GoogleTest program with every test case registered in
# ctest, and the headers that SALTUS_TEST_HEADERS names.
function(saltus_test name)
  cmake_parse_arguments(T "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(test_${name} ${T_SOURCES})
  target_link_libraries(test_${name} PRIVATE saltus_flags saltus_program_flags ${T_DEPENDS} GTest::gtest_main
                                             Eigen3::Eigen fmt::fmt)
  if(NOT SALTUS_SANITIZE) # operator new, in its shared library, must call those of tests/support/count_allocations.cpp
    foreach(counted malloc calloc realloc aligned_alloc posix_memalign free)
      target_link_options(test_${name} PRIVATE -Wl,--export-dynamic-symbol=${counted})
    endforeach()
  endif()
  saltus_reuse(test_${name} ${SALTUS_TEST_HEADERS})
  saltus_compiled_fast(test_${name})
  set(seconds 300)
  if(SALTUS_SANITIZE)
    set(seconds 3000)
  endif()
  # Printed values of parameters would put addresses into names.
  gtest_discover_tests(test_${name} TEST_PREFIX "${name}." NO_PRETTY_VALUES DISCOVERY_TIMEOUT 60
                                    PROPERTIES TIMEOUT ${seconds})
endfunction()
