# saltus_plugin(NAME SOURCE...): a shared library with registered controllers that a host loads by
# dlopen() (saltus/c/saltus_c.h). It exports the C interface only, so that its symbols do not mix
# with those of the host or of other plugins. Link further libraries by target_link_libraries().
set(SALTUS_PLUGIN_SYMBOLS ${CMAKE_CURRENT_LIST_DIR}/saltusPlugin.map)
function(saltus_plugin name)
  add_library(${name} MODULE ${ARGN})
  set_target_properties(${name} PROPERTIES PREFIX "" CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_link_libraries(${name} PRIVATE saltus::c saltus::core)
  target_link_options(${name} PRIVATE -Wl,--version-script=${SALTUS_PLUGIN_SYMBOLS} -Wl,-Bsymbolic -Wl,-z,defs
                                      -Wl,--as-needed)
  set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS ${SALTUS_PLUGIN_SYMBOLS})
endfunction()
