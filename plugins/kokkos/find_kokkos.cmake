# Target Kokkos::kokkos of an installed Kokkos, or of its sources (lib/kokkos of LAMMPS), in the folder GRANWAVE_KOKKOS.
if(TARGET Kokkos::kokkos)
  return()
endif()
if(EXISTS "${GRANWAVE_KOKKOS}/core/src/Kokkos_Core.hpp")
  add_subdirectory("${GRANWAVE_KOKKOS}" kokkos EXCLUDE_FROM_ALL)
else()
  find_package(Kokkos 4 REQUIRED CONFIG PATHS "${GRANWAVE_KOKKOS}" NO_DEFAULT_PATH)
endif()
