# Installation: the libraries of the enabled components with their public headers
# (public_headers.txt), and a CMake package that finds only the requested components.

include(CMakePackageConfigHelpers)
set(SALTUS_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/saltus)

# saltus_install_headers(COMPONENT): installs the public headers of a component under their include
# paths.
function(saltus_install_headers component)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/framework/cmake/public_headers.txt)
  file(STRINGS ${PROJECT_SOURCE_DIR}/framework/cmake/public_headers.txt lines REGEX "^${component} ")
  foreach(line ${lines})
    string(REGEX REPLACE "^${component} +" "" pattern ${line})
    set(is_there OFF)
    foreach(root ${SALTUS_INCLUDE_ROOTS})
      file(GLOB headers RELATIVE ${root} ${root}/saltus/${pattern})
      foreach(header ${headers})
        set(is_there ON)
        get_filename_component(folder ${header} DIRECTORY)
        install(FILES ${root}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder} COMPONENT ${component})
      endforeach()
    endforeach()
    if(NOT is_there)
      message(WARNING "framework/cmake/public_headers.txt: there is no header ${pattern}")
    endif()
  endforeach()
  foreach(line ${SALTUS_MOVED_HEADERS})
    if(line MATCHES "^${component} ([^ ]+) ")
      set(header saltus/${CMAKE_MATCH_1})
      get_filename_component(folder ${header} DIRECTORY)
      install(FILES ${SALTUS_MOVED_HEADERS_DIR}/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/${folder}
              COMPONENT ${component})
    endif()
  endforeach()
endfunction()

foreach(component ${SALTUS_ALL_COMPONENTS})
  if(SALTUS_HAS_${component})
    get_property(targets GLOBAL PROPERTY SALTUS_TARGETS_${component})
    if(TARGET saltus_component_${component})
      list(APPEND targets saltus_component_${component})
    endif()
    if(component STREQUAL "core")
      list(APPEND targets saltus_usage)
    endif()
    install(TARGETS ${targets} EXPORT saltus-${component}-targets
            ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}
            LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component}-runtime
                                                        NAMELINK_COMPONENT ${component}
            INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    install(EXPORT saltus-${component}-targets NAMESPACE saltus:: DESTINATION ${SALTUS_CMAKE_DIR}
            COMPONENT ${component})
    saltus_install_headers(${component})
  endif()
endforeach()

# If the closed loop is built with MuJoCo, its users link to MuJoCo too.
set(SALTUS_LEGGED_MUJOCO)
if(SALTUS_HAS_mujoco)
  set(SALTUS_LEGGED_MUJOCO mujoco)
endif()
# The files of the components are in the same folder. Each package installs its own file.
configure_package_config_file(${PROJECT_SOURCE_DIR}/framework/cmake/saltusConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/saltusConfig.cmake
                              INSTALL_DESTINATION ${SALTUS_CMAKE_DIR}
                              NO_CHECK_REQUIRED_COMPONENTS_MACRO)
# Before 1.0 every minor version may break compatibility.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/saltusConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/saltusConfig.cmake ${PROJECT_BINARY_DIR}/saltusConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/framework/cmake/saltusPlugin.cmake
              ${PROJECT_SOURCE_DIR}/framework/cmake/saltusPlugin.map
              ${PROJECT_SOURCE_DIR}/framework/cmake/saltusCasadi.cmake
        DESTINATION ${SALTUS_CMAKE_DIR} COMPONENT core)
