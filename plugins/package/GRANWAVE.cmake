# Flags of the files of this package. Without contraction the forces on both spheres of a pair are rounded identically;
# without errno and traps the square roots of a batch are vectorized.
if(CMAKE_CXX_STANDARD LESS 17)
  message(FATAL_ERROR "The GRANWAVE package needs C++17, found CMAKE_CXX_STANDARD=${CMAKE_CXX_STANDARD}")
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES "GNU|Clang|IntelLLVM")
  set_source_files_properties(${GRANWAVE_SOURCES} PROPERTIES
    COMPILE_OPTIONS "-ffp-contract=off;-fno-math-errno;-fno-trapping-math")
endif()
