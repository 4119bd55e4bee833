# saltus_casadi(NAME FILE.c...): a shared library of functions that CasADi generated as C code, for load_casadi() of
# saltus/model/casadi_function.hpp. It needs no library of CasADi.
function(saltus_casadi name)
  add_library(${name} MODULE ${ARGN})
  set_target_properties(${name} PROPERTIES PREFIX "" C_VISIBILITY_PRESET default)
  # Like the compiler's default for our formulas, without the assumptions of -ffast-math.
  target_compile_options(${name} PRIVATE -O2 -w)
  target_link_libraries(${name} PRIVATE m)
endfunction()
