# Selects the components to build and finds their third-party packages. A package is searched for
# only if its component is enabled. Each package gets one target name, visible to every folder and
# to enclosing projects:
#
#   core      Eigen3::Eigen  fmt::fmt  saltus::suitesparse
#   sundials  saltus::sundials_libraries
#   ipopt     saltus::ipopt_library
#   robots    saltus::urdf_libraries  saltus::mesh_library
#   dart      saltus::dart_libraries
#   mujoco    saltus::mujoco_library
#   c         no package: it uses those of core
#   legged    no package: it uses those of the other components
#   app       nlohmann_json::nlohmann_json  saltus::yaml_library  saltus::command_line_library
#
# Supported releases: Debian 12, Ubuntu 24.04, Debian 13. ./saltus installs the packages.
# saltusConfig.cmake.in finds the same libraries for users of an installed Saltus.

set(SALTUS_ALL_COMPONENTS core c sundials ipopt robots dart mujoco legged app)
set(SALTUS_COMPONENTS "found" CACHE STRING
    "Components to build, a list of: ${SALTUS_ALL_COMPONENTS}; or 'all'; or 'found': those whose packages are installed")
# Dependencies between components.
set(SALTUS_core_NEEDS)
set(SALTUS_c_NEEDS core)
set(SALTUS_sundials_NEEDS core)
set(SALTUS_ipopt_NEEDS core)
set(SALTUS_app_NEEDS core)
set(SALTUS_robots_NEEDS core app)
set(SALTUS_dart_NEEDS robots)
set(SALTUS_mujoco_NEEDS robots)
set(SALTUS_legged_NEEDS core app robots sundials ipopt dart)

if(SALTUS_COMPONENTS STREQUAL "all" OR SALTUS_COMPONENTS STREQUAL "found")
  set(SALTUS_WANTED ${SALTUS_ALL_COMPONENTS})
else()
  set(SALTUS_WANTED core ${SALTUS_COMPONENTS})
  foreach(component ${SALTUS_WANTED})
    if(NOT component IN_LIST SALTUS_ALL_COMPONENTS)
      message(FATAL_ERROR "SALTUS_COMPONENTS: there is no component '${component}'; the components are ${SALTUS_ALL_COMPONENTS}")
    endif()
  endforeach()
  foreach(pass RANGE 1 2) # direct and indirect dependencies: the depth of the table
    foreach(component ${SALTUS_WANTED})
      list(APPEND SALTUS_WANTED ${SALTUS_${component}_NEEDS})
    endforeach()
  endforeach()
  list(REMOVE_DUPLICATES SALTUS_WANTED)
endif()

# Enclosing projects link to our libraries, and through them to these.
set(CMAKE_FIND_PACKAGE_TARGETS_GLOBAL ON)

# Gives a library one name, independent of the name in its package.
function(saltus_external name)
  cmake_parse_arguments(E "" "" "LINK;INCLUDE" ${ARGN})
  if(NOT TARGET saltus::${name})
    add_library(saltus::${name} INTERFACE IMPORTED GLOBAL)
    target_link_libraries(saltus::${name} INTERFACE ${E_LINK})
    target_include_directories(saltus::${name} SYSTEM INTERFACE ${E_INCLUDE})
  endif()
endfunction()

# Each of these macros sets `missing` to the missing package, or leaves it empty.
macro(saltus_find_core)
  find_package(Eigen3 3.4 QUIET NO_MODULE)
  if(NOT Eigen3_FOUND)
    set(missing "Eigen 3.4 (libeigen3-dev)")
  endif()
  find_package(fmt QUIET)
  if(NOT fmt_FOUND)
    set(missing "fmt (libfmt-dev)")
  endif()
  # SuiteSparse has a CMake configuration only from version 7 on; the libraries are the same. The
  # licences of KLU and of the simplicial part of CHOLMOD suit a BSD library; UMFPACK and SPQR (GPL)
  # are not used.
  find_path(SALTUS_SUITESPARSE_INCLUDE_DIR klu.h PATH_SUFFIXES suitesparse)
  mark_as_advanced(SALTUS_SUITESPARSE_INCLUDE_DIR)
  set(suitesparse)
  foreach(part klu btf cholmod amd colamd camd ccolamd suitesparseconfig)
    find_library(SALTUS_${part}_LIBRARY ${part})
    mark_as_advanced(SALTUS_${part}_LIBRARY)
    list(APPEND suitesparse ${SALTUS_${part}_LIBRARY})
    if(NOT SALTUS_${part}_LIBRARY OR NOT SALTUS_SUITESPARSE_INCLUDE_DIR)
      set(missing "SuiteSparse (libsuitesparse-dev)")
    endif()
  endforeach()
  if(NOT missing)
    saltus_external(suitesparse LINK ${suitesparse} INCLUDE ${SALTUS_SUITESPARSE_INCLUDE_DIR})
  endif()
endmacro()

macro(saltus_find_c)
endmacro()

macro(saltus_find_sundials)
  # Version 7 looks for MPI, in C as well as C++. Its version file rejects ranges across 6 and 7.
  find_package(SUNDIALS QUIET CONFIG)
  if(NOT SUNDIALS_FOUND AND SUNDIALS_CONSIDERED_CONFIGS)
    # SUNDIALS is installed, but its configuration does not find one of its dependencies.
    set(missing "OpenMP and MPI that work with ${CMAKE_CXX_COMPILER_ID}, as SUNDIALS asks (clang: libomp-dev)")
  elseif(NOT SUNDIALS_FOUND)
    set(missing "SUNDIALS 6.4 to 7 (libsundials-dev)")
  elseif(SUNDIALS_VERSION VERSION_LESS 6.4 OR SUNDIALS_VERSION VERSION_GREATER_EQUAL 8)
    set(missing "SUNDIALS 6.4 to 7, in place of ${SUNDIALS_VERSION} (libsundials-dev)")
  else()
    set(sundials_parts)
    set(SALTUS_SUNDIALS_LIBRARY_NAMES) # for saltusConfig.cmake
    # Version 7 moved its base classes to a separate library.
    foreach(part cvodes arkode idas nvecserial sunmatrixdense sunlinsoldense sunnonlinsolnewton
                 sunnonlinsolfixedpoint core)
      if(TARGET SUNDIALS::${part}_shared)
        list(APPEND sundials_parts SUNDIALS::${part}_shared)
        string(APPEND SALTUS_SUNDIALS_LIBRARY_NAMES " sundials_${part}")
      endif()
    endforeach()
    if(SUNDIALS_VERSION VERSION_GREATER_EQUAL 7 AND TARGET MPI::MPI_C)
      string(APPEND SALTUS_SUNDIALS_LIBRARY_NAMES " mpi") # its headers name the null communicator
    endif()
    saltus_external(sundials_libraries LINK ${sundials_parts})
  endif()
endmacro()

macro(saltus_find_ipopt)
  find_package(PkgConfig QUIET)
  if(PkgConfig_FOUND)
    # The headers are in coin/ (3.11) or coin-or/ (3.14). The flags contain this folder, so sources
    # write #include <IpTNLP.hpp>.
    pkg_check_modules(IPOPT QUIET IMPORTED_TARGET GLOBAL ipopt)
  endif()
  if(IPOPT_FOUND)
    saltus_external(ipopt_library LINK PkgConfig::IPOPT)
  else()
    set(missing "Ipopt (coinor-libipopt-dev, pkg-config)")
  endif()
endmacro()

macro(saltus_find_yaml)
  find_package(yaml-cpp QUIET)
  if(NOT yaml-cpp_FOUND)
    set(missing "yaml-cpp (libyaml-cpp-dev)")
  elseif(TARGET yaml-cpp::yaml-cpp)
    saltus_external(yaml_library LINK yaml-cpp::yaml-cpp)
  else()
    saltus_external(yaml_library LINK yaml-cpp)
  endif()
endmacro()

macro(saltus_find_robots)
  # Up to version 3 its config file finds console_bridge, which it logs through; version 4 does not.
  find_package(urdfdom QUIET)
  find_package(console_bridge QUIET)
  find_package(assimp QUIET)
  if(NOT urdfdom_FOUND OR NOT console_bridge_FOUND)
    set(missing "urdfdom and console_bridge (liburdfdom-dev libconsole-bridge-dev)")
  elseif(NOT assimp_FOUND)
    set(missing "assimp (libassimp-dev)")
  else()
    saltus_external(urdf_libraries LINK urdfdom::urdfdom_model console_bridge::console_bridge)
    saltus_external(mesh_library LINK assimp::assimp)
  endif()
endmacro()

# DART is a simulator of whole bodies. Its headers cause warnings.
macro(saltus_find_dart)
  find_package(DART 6.12 QUIET COMPONENTS collision-bullet collision-ode CONFIG)
  if(DART_FOUND)
    saltus_external(dart_libraries LINK dart dart-collision-bullet dart-collision-ode)
  else()
    set(missing "DART 6.12 (libdart-collision-bullet-dev libdart-collision-ode-dev libdart-external-ikfast-dev)")
  endif()
endmacro()

# MuJoCo is a second simulator. Debian's config file requires OpenGL and the headers of qhull, which
# the package does not install and simulation does not need.
macro(saltus_find_mujoco)
  find_path(SALTUS_MUJOCO_INCLUDE_DIR mujoco/mujoco.h)
  find_library(SALTUS_MUJOCO_LIBRARY mujoco)
  mark_as_advanced(SALTUS_MUJOCO_INCLUDE_DIR SALTUS_MUJOCO_LIBRARY)
  set(missing "MuJoCo 2.2.2 to 2.x (libmujoco-dev)")
  if(SALTUS_MUJOCO_INCLUDE_DIR AND SALTUS_MUJOCO_LIBRARY)
    file(STRINGS ${SALTUS_MUJOCO_INCLUDE_DIR}/mujoco/mujoco.h version_line REGEX "mjVERSION_HEADER")
    string(REGEX MATCH "[0-9]+$" SALTUS_MUJOCO_VERSION "${version_line}")
    # Release 3 has different functions that read descriptions from memory.
    if(SALTUS_MUJOCO_VERSION GREATER_EQUAL 222 AND SALTUS_MUJOCO_VERSION LESS 300)
      set(missing)
      saltus_external(mujoco_library LINK ${SALTUS_MUJOCO_LIBRARY} INCLUDE ${SALTUS_MUJOCO_INCLUDE_DIR})
    endif()
  endif()
endmacro()

macro(saltus_find_legged)
endmacro()

macro(saltus_find_app)
  saltus_find_yaml()
  find_package(nlohmann_json QUIET)
  if(NOT nlohmann_json_FOUND)
    set(missing "nlohmann-json (nlohmann-json3-dev)")
  endif()
  find_package(CLI11 QUIET)
  if(CLI11_FOUND)
    saltus_external(command_line_library LINK CLI11::CLI11)
  else()
    set(missing "CLI11 (libcli11-dev)")
  endif()
endmacro()

# Each component follows its dependencies in this list.
foreach(component core c sundials ipopt app robots dart mujoco legged)
  set(SALTUS_HAS_${component} OFF)
  if(component IN_LIST SALTUS_WANTED)
    set(missing)
    foreach(needed ${SALTUS_${component}_NEEDS})
      if(NOT SALTUS_HAS_${needed})
        set(missing "the component ${needed}")
      endif()
    endforeach()
    if(NOT missing)
      cmake_language(CALL saltus_find_${component})
    endif()
    if(NOT missing)
      set(SALTUS_HAS_${component} ON)
    elseif(component STREQUAL "core" OR NOT SALTUS_COMPONENTS STREQUAL "found")
      # MuJoCo is not part of every supported release; the other packages are.
      if(component STREQUAL "mujoco" AND SALTUS_COMPONENTS STREQUAL "all")
        message(STATUS "No ${missing}: plant=mujoco will say so")
      else()
        message(FATAL_ERROR "Saltus: the component ${component} needs ${missing}; -D SALTUS_COMPONENTS=... chooses others")
      endif()
    else()
      message(STATUS "Saltus without ${component}: no ${missing}")
    endif()
  endif()
endforeach()
