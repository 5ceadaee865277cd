# Every outside library, found once, here. All of them are packages of Debian 12 and Ubuntu 24.04 (tools/setup installs them).
find_package(Threads REQUIRED)
if(TALIK_FUZZ) # one thread, and a compiler that may have no OpenMP
  add_library(OpenMP::OpenMP_CXX INTERFACE IMPORTED GLOBAL)
else()
  find_package(OpenMP REQUIRED COMPONENTS CXX)
endif()
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Boost 1.74 REQUIRED)
find_package(HDF5 1.10 REQUIRED COMPONENTS C)
find_package(ZLIB REQUIRED) # with HDF5
find_package(CLI11 2.1 REQUIRED)
find_package(fmt 9 REQUIRED)
find_package(spdlog 1.10 REQUIRED)
find_package(nlohmann_json 3.11 REQUIRED)
find_path(TALIK_HIGHWAY hwy/highway.h REQUIRED) # headers only: kernels dispatch by file, not by Highway
find_package(tomlplusplus QUIET)
if(NOT tomlplusplus_FOUND)
  find_package(PkgConfig REQUIRED)
  pkg_check_modules(TOMLPLUSPLUS REQUIRED IMPORTED_TARGET tomlplusplus)
  add_library(tomlplusplus::tomlplusplus ALIAS PkgConfig::TOMLPLUSPLUS)
endif()
set(TALIK_LIBRARIES fmt::fmt spdlog::spdlog tomlplusplus::tomlplusplus hdf5::hdf5 ZLIB::ZLIB OpenMP::OpenMP_CXX)
if(TALIK_STATIC)
  include(TalikStatic)
endif()

# The CUDA backend is left out, with one line saying so, where no usable compiler is found.
set(TALIK_HAS_CUDA OFF)
if(NOT TALIK_CUDA STREQUAL "off")
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    # Machine code for A100 (8.0) and H100, H200 (9.0), and PTX of the latter for what comes after them.
    set(TALIK_CUDA_ARCHITECTURES 80-real 90 CACHE STRING "Compute capabilities that the CUDA backend is built for")
    set(CMAKE_CUDA_ARCHITECTURES ${TALIK_CUDA_ARCHITECTURES})
    enable_language(CUDA)
    if(CMAKE_CUDA_COMPILER_VERSION VERSION_GREATER_EQUAL 12)
      set(TALIK_HAS_CUDA ON)
      if(NOT CMAKE_CUDA20_STANDARD_COMPILE_OPTION) # CMake 3.25 does not know that nvcc 13 speaks it
        set(CMAKE_CUDA20_STANDARD_COMPILE_OPTION "-std=c++20")
        set(CMAKE_CUDA20_EXTENSION_COMPILE_OPTION "-std=c++20")
      endif()
    endif()
  endif()
  if(NOT TALIK_HAS_CUDA)
    if(TALIK_CUDA STREQUAL "on")
      message(FATAL_ERROR "TALIK_CUDA=on, but no nvcc of CUDA 12 or newer was found (install it, or set CUDACXX)")
    endif()
    message(STATUS "Talik: no nvcc of CUDA 12 or newer found: building without the CUDA backend")
  endif()
endif()

# Farms on other machines need MPI; without it that transport is left out, with one line saying so.
set(TALIK_HAS_MPI OFF)
if(NOT TALIK_MPI STREQUAL "off" AND NOT TALIK_SANITIZE_THREAD) # MPI's own threads are not instrumented
  find_package(MPI QUIET COMPONENTS C)
  set(TALIK_HAS_MPI ${MPI_C_FOUND})
  if(NOT TALIK_HAS_MPI)
    if(TALIK_MPI STREQUAL "on")
      message(FATAL_ERROR "TALIK_MPI=on, but no MPI was found (apt-get install libopenmpi-dev openmpi-bin)")
    endif()
    message(STATUS "Talik: no MPI found: building without --exchange mpi (farms on other machines)")
  endif()
endif()

if(TALIK_TESTS)
  find_package(Catch2 REQUIRED) # 2.13 on Debian 12, 3.4 on Ubuntu 24.04: tests/support/catch.hpp bridges the two
endif()
