# The compiler flags of every target of ours.
add_library(talik_flags INTERFACE)
target_include_directories(talik_flags INTERFACE ${CMAKE_SOURCE_DIR})
# No contraction of a*b+c: the same source must give the same bits in every template instance and on every machine.
target_compile_options(talik_flags INTERFACE
  $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wshadow -Wnon-virtual-dtor -ffp-contract=off>)
if(TALIK_SANITIZE)
  target_compile_options(talik_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer>)
  target_link_options(talik_flags INTERFACE -fsanitize=address,undefined)
endif()
if(TALIK_SANITIZE_THREAD)
  target_compile_options(talik_flags INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fsanitize=thread>)
  target_link_options(talik_flags INTERFACE -fsanitize=thread)
endif()

# talik_library(NAME folder-relative sources... LINKS targets...)
function(talik_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINKS" ${ARGN})
  add_library(${name} STATIC ${ARG_SOURCES})
  target_link_libraries(${name} PUBLIC talik_flags ${ARG_LINKS})
endfunction()
