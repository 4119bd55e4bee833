# One way to declare a target: warnings, language level and the flags that must be the same in
# every object file of the project.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, Debug, RelWithDebInfo" FORCE)
endif()

set(SALTUS_MARCH "" CACHE STRING "Value of -march for the numerical code; empty is portable")
option(SALTUS_WERROR "Treat warnings as errors" ON)
option(SALTUS_SANITIZE "Address and undefined-behaviour sanitizers" OFF)

# What every object needs, and with it the instructions of the processor.
add_library(saltus_baseline_flags INTERFACE)
add_library(saltus_flags INTERFACE)
target_link_libraries(saltus_flags INTERFACE saltus_baseline_flags)
# Headers are included as <saltus/ocp/phase.hpp>, in the source tree as in an installed library: links
# in the build folder give the folders that name, and nothing else enters a user's include path.
set(SALTUS_INCLUDE_DIR ${PROJECT_BINARY_DIR}/include)
file(MAKE_DIRECTORY ${SALTUS_INCLUDE_DIR}/saltus)
foreach(layer core autodiff model ocp transcription qp solver mpc yaml app)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/framework/${layer} ${SALTUS_INCLUDE_DIR}/saltus/${layer} SYMBOLIC)
endforeach()
foreach(layer integrators robots)
  file(CREATE_LINK ${PROJECT_SOURCE_DIR}/${layer} ${SALTUS_INCLUDE_DIR}/saltus/${layer} SYMBOLIC)
endforeach()
target_include_directories(saltus_baseline_flags INTERFACE ${SALTUS_INCLUDE_DIR})
# What is not a library (problems, tests, benchmarks) also includes by the path from the top folder.
add_library(saltus_inside INTERFACE)
target_include_directories(saltus_inside INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(saltus_baseline_flags INTERFACE
                       -Wall -Wextra -Wshadow -Wnon-virtual-dtor
                       $<$<BOOL:${SALTUS_WERROR}>:-Werror>)
# Packaged libraries (DART) are built for 16-byte alignment; the same bound everywhere keeps Eigen
# types layout-compatible whatever -march is chosen.
target_compile_definitions(saltus_baseline_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
# Programs export nothing: a shared library would otherwise take their instances of Eigen's inline
# functions, built for another processor, in place of its own.
target_link_options(saltus_flags INTERFACE
                    -Wl,--exclude-libs,ALL
                    -Wl,--version-script=${PROJECT_SOURCE_DIR}/framework/cmake/nothing_exported.map)
if(SALTUS_MARCH)
  target_compile_options(saltus_flags INTERFACE -march=${SALTUS_MARCH})
  # gcc 12 loads a wide constant such as {1, 1, 0, 0} that it stores in one piece as a broadcast of its
  # first half where -march has AVX-512: {exactly(1), exactly(0)} became [1, 1] twice. Pieces of 16
  # bytes, as without -march, leave vector loops alone.
  include(CheckCXXCompilerFlag)
  check_cxx_compiler_flag(-mmove-max=128 SALTUS_HAS_MOVE_MAX)
  if(SALTUS_HAS_MOVE_MAX)
    target_compile_options(saltus_flags INTERFACE -mmove-max=128 -mstore-max=128)
  endif()
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    # With wide vectors gcc complains about its own intrinsics (undefined registers, GCC bug 105593)
    # and about vector loops of Eigen that small matrices never enter. Portable builds still check.
    target_compile_options(saltus_flags INTERFACE -Wno-maybe-uninitialized -Wno-uninitialized
                                                  -Wno-array-bounds
                                                  -Wno-stringop-overflow -Wno-stringop-overread)
  endif()
endif()
if(SALTUS_SANITIZE)
  target_compile_options(saltus_baseline_flags INTERFACE -fsanitize=address,undefined
                                                -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(saltus_baseline_flags INTERFACE -fsanitize=address,undefined)
endif()

# saltus_layer(NAME SOURCES a.cpp ... DEPENDS saltus::core ... [PRIVATE_DEPENDS ...])
# declares the library saltus_NAME with the alias saltus::NAME.
function(saltus_layer name)
  cmake_parse_arguments(LAYER "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS" ${ARGN})
  add_library(saltus_${name} STATIC ${LAYER_SOURCES})
  add_library(saltus::${name} ALIAS saltus_${name})
  target_link_libraries(saltus_${name} PUBLIC saltus_flags ${LAYER_DEPENDS}
                                       PRIVATE ${LAYER_PRIVATE_DEPENDS})
endfunction()

# saltus_test(NAME SOURCES ... DEPENDS ...): one GoogleTest program, every case known to ctest.
function(saltus_test name)
  cmake_parse_arguments(T "" "" "SOURCES;DEPENDS" ${ARGN})
  add_executable(test_${name} ${T_SOURCES})
  target_link_libraries(test_${name} PRIVATE saltus_flags ${T_DEPENDS} GTest::gtest_main)
  gtest_discover_tests(test_${name} TEST_PREFIX "${name}." DISCOVERY_TIMEOUT 60
                                    PROPERTIES TIMEOUT 300)
endfunction()
