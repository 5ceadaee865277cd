# TALIK_STATIC: programs that hold every library but the C library, for machines that have nothing else (tools/gpu-bundle). What
# distributions have no static library of is compiled in from its headers.
get_target_property(hdf5_headers hdf5::hdf5 INTERFACE_INCLUDE_DIRECTORIES)
function(talik_find_archive variable)
  find_library(${variable} NAMES ${ARGN} REQUIRED PATHS ${CMAKE_CXX_IMPLICIT_LINK_DIRECTORIES} PATH_SUFFIXES hdf5/serial)
endfunction()
talik_find_archive(TALIK_HDF5_ARCHIVE libhdf5.a libhdf5_serial.a)
talik_find_archive(TALIK_SZIP_ARCHIVE libsz.a)
talik_find_archive(TALIK_AEC_ARCHIVE libaec.a)
talik_find_archive(TALIK_ZLIB_ARCHIVE libz.a)
talik_find_archive(TALIK_OPENMP_ARCHIVE libgomp.a)

add_library(talik_static STATIC ${CMAKE_CURRENT_LIST_DIR}/hdf5_without_network.c)
target_include_directories(talik_static SYSTEM INTERFACE ${hdf5_headers})
target_compile_options(talik_static INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fopenmp>)
target_compile_definitions(talik_static INTERFACE TOML_HEADER_ONLY=1)
target_link_options(talik_static INTERFACE -static-libstdc++ -static-libgcc)
target_link_libraries(talik_static INTERFACE
  ${TALIK_HDF5_ARCHIVE} $<TARGET_FILE:talik_static> ${TALIK_SZIP_ARCHIVE} ${TALIK_AEC_ARCHIVE} ${TALIK_ZLIB_ARCHIVE} ${TALIK_OPENMP_ARCHIVE} m ${CMAKE_DL_LIBS})
set(TALIK_LIBRARIES fmt::fmt-header-only spdlog::spdlog_header_only talik_static)
