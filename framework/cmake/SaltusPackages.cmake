# Debian packages: `cmake --preset package`, build, `cpack --config build-package/CPackConfig.cmake`.
#
#   libsaltus-dev           core: headers and static libraries, find_package(saltus)
#   libsaltus-NAME-dev      the components c, sundials, ipopt, app, robots, dart, mujoco, legged
#   libsaltus-dart0.3       the shared library that hides DART
#   saltus                  the program with its scripts and data
#
# dpkg-shlibdeps computes the dependencies of shared libraries and programs. The dependencies of
# static libraries are listed here, by their package names in Debian and Ubuntu.

if(BUILD_SHARED_LIBS)
  message(FATAL_ERROR "The packages contain static libraries: configure them without BUILD_SHARED_LIBS")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME saltus)
set(CPACK_PACKAGE_VENDOR "Saltus")
# The project has no contact address. Distributors of packages set their own.
set(CPACK_PACKAGE_CONTACT "The Saltus developers" CACHE STRING "Maintainer of the packages: NAME <ADDRESS>")
set(CPACK_PACKAGING_INSTALL_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_STRIP_FILES ON)
set(SALTUS_SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")

# dpkg requires these files in share/doc of every package.
set(changelog ${PROJECT_BINARY_DIR}/changelog.Debian)
set(signature ${CPACK_PACKAGE_CONTACT})
if(NOT signature MATCHES "<")
  string(APPEND signature " <>")
endif()
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC) # of SOURCE_DATE_EPOCH if that is set
file(WRITE ${changelog} "saltus (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * What changed is in CHANGELOG.md of the project.

 -- ${signature}  ${date}
")
execute_process(COMMAND gzip -9nf ${changelog})
file(READ ${PROJECT_SOURCE_DIR}/LICENSE license)
file(WRITE ${PROJECT_BINARY_DIR}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: saltus

${license}")

# saltus_package(COMPONENT NAME SUMMARY TEXT [DEPENDS ...])
function(saltus_package component name summary text)
  cmake_parse_arguments(P "" "" "DEPENDS" ${ARGN})
  string(TOUPPER ${component} upper)
  list(JOIN P_DEPENDS ", " depends)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}" PARENT_SCOPE)
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}" PARENT_SCOPE)
  install(FILES ${PROJECT_BINARY_DIR}/copyright ${changelog}.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  set(CPACK_COMPONENTS_ALL ${CPACK_COMPONENTS_ALL} ${component} PARENT_SCOPE)
endfunction()

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own summary
set(about "Saltus plans through the events of hybrid systems: problems written once as
formulas, exact derivatives and sparsity, solvers fast enough for control.")
set(CPACK_COMPONENTS_ALL)
saltus_package(core libsaltus-dev "hybrid model predictive control: headers and libraries" "${about}
This package holds the core: formulas, problems, transcription, solvers."
  DEPENDS libeigen3-dev libfmt-dev libsuitesparse-dev)
if(SALTUS_HAS_c)
  saltus_package(c libsaltus-c-dev "hybrid model predictive control: C interface of plugins"
    "${about}\nThis package holds the C interface of controllers in shared libraries."
    DEPENDS "libsaltus-dev ${version}")
endif()
if(SALTUS_HAS_sundials)
  saltus_package(sundials libsaltus-sundials-dev "hybrid model predictive control: integrators of SUNDIALS"
    "${about}\nThis package holds the adaptive integrators CVODES and ARKODE."
    DEPENDS "libsaltus-dev ${version}" libsundials-dev)
endif()
if(SALTUS_HAS_ipopt)
  saltus_package(ipopt libsaltus-ipopt-dev "hybrid model predictive control: Ipopt as a solver"
    "${about}\nThis package holds the interface to Ipopt."
    DEPENDS "libsaltus-dev ${version}" coinor-libipopt-dev)
endif()
if(SALTUS_HAS_app)
  saltus_package(app libsaltus-app-dev "hybrid model predictive control: parts of programs"
    "${about}\nThis package holds what programs need: settings, command lines, tables."
    DEPENDS "libsaltus-dev ${version}" nlohmann-json3-dev libyaml-cpp-dev)
endif()
if(SALTUS_HAS_robots)
  saltus_package(robots libsaltus-robots-dev "hybrid model predictive control: legged robots"
    "${about}\nThis package holds models, contacts and controllers of legged robots."
    DEPENDS "libsaltus-dev ${version}" "libsaltus-app-dev ${version}" liburdfdom-dev libconsole-bridge-dev libassimp-dev)
endif()
if(SALTUS_HAS_dart)
  saltus_package(dart-runtime libsaltus-dart${SALTUS_SOVERSION} "hybrid model predictive control: plant in DART"
    "${about}\nThis package holds the shared library that simulates a robot in DART.")
  set(CPACK_DEBIAN_DART-RUNTIME_PACKAGE_SECTION libs)
  set(CPACK_DEBIAN_DART-RUNTIME_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
  set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY "=")
  file(WRITE ${PROJECT_BINARY_DIR}/triggers "activate-noawait ldconfig\n")
  set(CPACK_DEBIAN_DART-RUNTIME_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/triggers)
  saltus_package(dart libsaltus-dart-dev "hybrid model predictive control: plant in DART, headers"
    "${about}\nThis package is for programs that simulate a robot in DART."
    DEPENDS "libsaltus-robots-dev ${version}" "libsaltus-dart${SALTUS_SOVERSION} ${version}")
endif()
if(SALTUS_HAS_mujoco)
  saltus_package(mujoco libsaltus-mujoco-dev "hybrid model predictive control: plant in MuJoCo"
    "${about}\nThis package is for programs that simulate a robot in MuJoCo."
    DEPENDS "libsaltus-robots-dev ${version}" libmujoco-dev)
endif()
if(SALTUS_HAS_legged)
  set(needs)
  foreach(component sundials ipopt app robots dart ${SALTUS_LEGGED_MUJOCO})
    list(APPEND needs "libsaltus-${component}-dev ${version}")
  endforeach()
  saltus_package(legged libsaltus-legged-dev "hybrid model predictive control: bipeds in closed loop"
    "${about}\nThis package holds a biped in closed loop: steps, planners, plants, verdicts."
    DEPENDS "libsaltus-dev ${version}" ${needs})
endif()
if(SALTUS_BUILD_PROGRAM)
  saltus_package(program saltus "hybrid model predictive control: program and examples"
    "${about}\nThis package holds the program that runs and draws the project's problems."
    DEPENDS "libsaltus-dart${SALTUS_SOVERSION} ${version}" python3)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "python3-matplotlib, python3-venv, libjs-three")
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/robots/saltus/robots/dart)
endif()
include(CPack)
