# What both ARM builds share: the sysroot, where CMake looks, and how a program is run. Set before: SORTIE_ARCH
# (Debian's name), SORTIE_TRIPLE (compiler prefix), SORTIE_QEMU (emulator).
set(CMAKE_SYSTEM_NAME Linux)
# gcc, or clang on the C++ library of Debian's cross gcc (SORTIE_CROSS_CLANG, for equality of digests).
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SORTIE_CROSS_CLANG)
if(SORTIE_CROSS_CLANG)
  set(CMAKE_CXX_COMPILER clang++)
  set(CMAKE_C_COMPILER clang)
  set(CMAKE_CXX_COMPILER_TARGET ${SORTIE_TRIPLE})
  set(CMAKE_C_COMPILER_TARGET ${SORTIE_TRIPLE})
else()
  set(CMAKE_CXX_COMPILER ${SORTIE_TRIPLE}-g++)
  set(CMAKE_C_COMPILER ${SORTIE_TRIPLE}-gcc)
endif()

# Once per configuration; the trial builds that CMake makes along the way know the answer already.
if(NOT SORTIE_SYSROOT)
  execute_process(COMMAND ${CMAKE_CURRENT_LIST_DIR}/sysroot ${SORTIE_ARCH} OUTPUT_VARIABLE SORTIE_SYSROOT
    OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
endif()
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES SORTIE_SYSROOT)

set(CMAKE_FIND_ROOT_PATH ${SORTIE_SYSROOT} ${SORTIE_PREFIX})  # SORTIE_PREFIX: where else ARM libraries are installed
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_LIBRARY_ARCHITECTURE ${SORTIE_TRIPLE})

# The C library comes with the compiler; what the sysroot's libraries need in turn lies in the sysroot.
set(libraries ${SORTIE_SYSROOT}/usr/lib/${SORTIE_TRIPLE})
set(CMAKE_EXE_LINKER_FLAGS_INIT "-Wl,-rpath-link,${libraries} -Wl,-rpath-link,${SORTIE_SYSROOT}/lib/${SORTIE_TRIPLE}")
set(CMAKE_CROSSCOMPILING_EMULATOR ${SORTIE_QEMU} -L /usr/${SORTIE_TRIPLE}
  -E LD_LIBRARY_PATH=${libraries}:${SORTIE_SYSROOT}/lib/${SORTIE_TRIPLE}:/usr/${SORTIE_TRIPLE}/lib)
