# Warnings are errors, on both compilers. Third-party headers are system headers and stay silent.
add_library(tellurion_warnings INTERFACE)
target_compile_options(tellurion_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Werror -Wshadow -Wconversion -Wsign-conversion -Wold-style-cast
  -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wunused -Wnull-dereference -Wdouble-promotion
  $<$<CXX_COMPILER_ID:GNU>:-Wduplicated-cond -Wlogical-op>)
# g++ 12 sees null dereferences and overruns inside inlined library code that are not there (GCC bugs 105329, 106199).
# Designated initialisers leave out fields on purpose; both compilers warn of it in C++.
target_compile_options(tellurion_warnings INTERFACE -Wno-missing-field-initializers
  $<$<CXX_COMPILER_ID:GNU>:-Wno-null-dereference -Wno-restrict -Wno-maybe-uninitialized>)

if(TELLURION_SANITIZE)
  add_compile_options(-fsanitize=${TELLURION_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TELLURION_SANITIZE})
endif()
