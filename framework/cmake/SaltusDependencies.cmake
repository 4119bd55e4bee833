# Every third-party package the project uses, found once and given one target name each.
#
#   Eigen3::Eigen  fmt::fmt  yaml-cpp  nlohmann_json::nlohmann_json  urdfdom::urdfdom_model
#   console_bridge::console_bridge
#   SUNDIALS::cvodes_shared ...  PkgConfig::IPOPT  saltus::suitesparse
#   GTest::gtest_main (tests)  benchmark::benchmark (benchmarks)
#
# The releases in view: Debian 12, Ubuntu 24.04, Debian 13. ./saltus installs the packages.

find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(yaml-cpp REQUIRED)
find_package(nlohmann_json REQUIRED)

# Version 7 looks for MPI, in C as well as C++. Its version file refuses ranges across 6 and 7.
find_package(SUNDIALS REQUIRED CONFIG)
if(SUNDIALS_VERSION VERSION_LESS 6.4 OR SUNDIALS_VERSION VERSION_GREATER_EQUAL 8)
  message(FATAL_ERROR "SUNDIALS 6.4 to 7 is needed; ${SUNDIALS_VERSION} was found")
endif()

# Headers lie in coin/ (3.11) or coin-or/ (3.14), and the flags say so: #include <IpTNLP.hpp>.
pkg_check_modules(IPOPT REQUIRED IMPORTED_TARGET ipopt)

# Up to version 3 its config file brings console_bridge along, through which it logs; 4 does not.
find_package(urdfdom REQUIRED)
find_package(console_bridge REQUIRED)

# SuiteSparse describes itself to CMake from version 7 on only; the libraries are the same few.
# KLU and CHOLMOD's simplicial part suit a BSD library; UMFPACK and SPQR (GPL) are left out.
find_path(SALTUS_SUITESPARSE_INCLUDE_DIR klu.h PATH_SUFFIXES suitesparse REQUIRED)
mark_as_advanced(SALTUS_SUITESPARSE_INCLUDE_DIR)
add_library(saltus_suitesparse INTERFACE)
add_library(saltus::suitesparse ALIAS saltus_suitesparse)
target_include_directories(saltus_suitesparse SYSTEM INTERFACE ${SALTUS_SUITESPARSE_INCLUDE_DIR})
foreach(part klu btf cholmod amd colamd camd ccolamd suitesparseconfig)
  find_library(SALTUS_${part}_LIBRARY ${part} REQUIRED)
  mark_as_advanced(SALTUS_${part}_LIBRARY)
  target_link_libraries(saltus_suitesparse INTERFACE ${SALTUS_${part}_LIBRARY})
endforeach()

# Simulation of the whole body. Its headers are not warning-free.
find_package(DART 6.12 REQUIRED COMPONENTS collision-bullet collision-ode CONFIG)
add_library(saltus_dart_packages INTERFACE)
target_link_libraries(saltus_dart_packages INTERFACE dart dart-collision-bullet dart-collision-ode)

# A second simulator, optional. Debian's own config file names OpenGL and the headers of qhull, which
# the package does not bring along and simulation does not need.
find_path(SALTUS_MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
find_library(SALTUS_MUJOCO_LIBRARY mujoco)
mark_as_advanced(SALTUS_MUJOCO_INCLUDE_DIR SALTUS_MUJOCO_LIBRARY)
set(SALTUS_HAS_MUJOCO OFF)
if(SALTUS_MUJOCO_INCLUDE_DIR AND SALTUS_MUJOCO_LIBRARY)
  file(STRINGS ${SALTUS_MUJOCO_INCLUDE_DIR}/mujoco/mujoco.h version_line REGEX "mjVERSION_HEADER")
  string(REGEX MATCH "[0-9]+$" SALTUS_MUJOCO_VERSION "${version_line}")
  # Release 3 reads descriptions from memory by other calls.
  if(SALTUS_MUJOCO_VERSION GREATER_EQUAL 222 AND SALTUS_MUJOCO_VERSION LESS 300)
    set(SALTUS_HAS_MUJOCO ON)
    add_library(saltus_mujoco_package INTERFACE)
    target_include_directories(saltus_mujoco_package SYSTEM INTERFACE ${SALTUS_MUJOCO_INCLUDE_DIR})
    target_link_libraries(saltus_mujoco_package INTERFACE ${SALTUS_MUJOCO_LIBRARY})
  endif()
endif()
if(NOT SALTUS_HAS_MUJOCO)
  message(STATUS "No MuJoCo 2.2.2 to 2.x: plant=mujoco will say so")
endif()

if(SALTUS_BUILD_TESTS OR NOT DEFINED SALTUS_BUILD_TESTS)
  find_package(GTest REQUIRED)
  include(GoogleTest)
endif()
if(SALTUS_BUILD_BENCHMARKS OR NOT DEFINED SALTUS_BUILD_BENCHMARKS)
  find_package(benchmark REQUIRED)
endif()
