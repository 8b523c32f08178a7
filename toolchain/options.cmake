# Compile options of every target, and the flags that make arithmetic repeatable across compilers and processors.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE RelWithDebInfo CACHE STRING "" FORCE)
endif()

set(SORTIE_SANITIZE "" CACHE STRING "Sanitizers to build with: address,undefined or thread; empty for none")
option(SORTIE_FUZZ "Build the fuzzers (clang only)" OFF)
option(SORTIE_COVERAGE "Count executed lines; the target coverage writes the report" OFF)

# GCC collects its own garbage from 128 MB on: a tenth of the time of the larger files here (-ftime-report). Half a gigabyte a job is there.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options("SHELL:--param ggc-min-heapsize=524288")
endif()

# Debug builds check every container access; sanitizers stop at the first finding.
add_compile_options($<$<CONFIG:Debug>:-D_GLIBCXX_ASSERTIONS>)
if(SORTIE_SANITIZE)
  add_compile_options(-fsanitize=${SORTIE_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${SORTIE_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")  # as gcc says it
    if(SORTIE_SANITIZE MATCHES "address")
      add_compile_definitions(__SANITIZE_ADDRESS__=1)
    elseif(SORTIE_SANITIZE STREQUAL "thread")
      add_compile_definitions(__SANITIZE_THREAD__=1)
    endif()
  endif()
endif()
if(SORTIE_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link)
endif()
if(SORTIE_COVERAGE)
  add_compile_options(--coverage -fprofile-update=atomic)
  add_link_options(--coverage)
else()
  # The same sources give the same archives wherever they lie.
  add_compile_options(-ffile-prefix-map=${PROJECT_SOURCE_DIR}=. -ffile-prefix-map=${PROJECT_BINARY_DIR}=build)
endif()

# A compiler cache, where there is one and nothing else was asked for.
find_program(SORTIE_CCACHE ccache)
mark_as_advanced(SORTIE_CCACHE)
if(SORTIE_CCACHE AND NOT DEFINED CMAKE_CXX_COMPILER_LAUNCHER)
  # It learns what a file includes from the compiler, not from a preprocessor's run of its own, which costs a quarter of
  # a build from nothing; and it may keep what is compiled with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_DEPEND=1 CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
    CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 ${SORTIE_CCACHE})
  # clang keeps a header's time in what it precompiles: a second build would take nothing that includes it from the cache.
  add_compile_options("$<$<COMPILE_LANG_AND_ID:CXX,Clang>:SHELL:-Xclang -fno-pch-timestamp>")
endif()

# Files beyond 2 GiB on 32 bits, in every unit alike: a batch has other files' headers before those of the log.
add_compile_definitions(_FILE_OFFSET_BITS=64)

# Replayable arithmetic: no fused multiply-add, no fast-math, no SLP vectorisation (GCC 12 fuses there in spite of
# -ffp-contract=off), one sign of char, and Eigen without its own SIMD kernels (their summation order differs by CPU).
add_library(sortie_strict INTERFACE)
add_library(Sortie::strict ALIAS sortie_strict)
set_target_properties(sortie_strict PROPERTIES EXPORT_NAME strict)
target_compile_features(sortie_strict INTERFACE cxx_std_20)
target_compile_options(sortie_strict INTERFACE -ffp-contract=off -fno-fast-math -fno-tree-slp-vectorize -fsigned-char)
target_compile_definitions(sortie_strict INTERFACE EIGEN_DONT_VECTORIZE EIGEN_MPL2_ONLY)

# Warnings are errors inside the repository; users of the library keep their own.
add_library(sortie_warnings INTERFACE)
target_compile_options(sortie_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Wdouble-promotion -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 sees errors inside std::string's own operator+ where there are none (its bugs 105329 and 105651).
  target_compile_options(sortie_warnings INTERFACE -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow
                                                   -Wno-stringop-overread)
endif()
if(SORTIE_SANITIZE AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # Often false between what sanitizers add, so it does not stop a build; but look: once it was GCC that was wrong.
  target_compile_options(sortie_warnings INTERFACE -Wno-error=maybe-uninitialized)
endif()
if(CMAKE_SYSTEM_PROCESSOR MATCHES "^arm" AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CMAKE_SYSTEM_NAME STREQUAL "Generic")
  target_compile_options(sortie_warnings INTERFACE -Wno-psabi)
endif()

# Most of a file's time goes into what it includes. Not for release, whose tasks' instructions are counted.
option(SORTIE_JUMBO "Compile all files of runtime, program and tests in batches: less time from nothing, more after a small change" OFF)

# sortie_batches(<target> <size> [<folders>...]): compiles `size` files of a folder at a time, in the order of their names;
# without folders: of every folder. Files with definitions of their own stay alone. By folder, so that names meet only where a
# reader looks for both.
function(sortie_batches target size)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE absolute)
    cmake_path(GET absolute PARENT_PATH folder)
    cmake_path(RELATIVE_PATH folder BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR})
    if(folder IN_LIST ARGN OR NOT ARGN)
      string(MAKE_C_IDENTIFIER "${folder}" name)
      math(EXPR count_${name} "0${count_${name}} + 1")
      math(EXPR batch "(${count_${name}} - 1) / ${size}")
      set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${target}_${name}_${batch}")
      get_source_file_property(alone ${source} SKIP_UNITY_BUILD_INCLUSION)
      if(NOT alone)
        set_property(GLOBAL APPEND PROPERTY SORTIE_BATCHED ${absolute})
      endif()
    endif()
  endforeach()
endfunction()

# sortie_library(<folder> [SOURCES <files>...] [DEPENDS <targets>...]): a static library of every .cpp below the folder, or
# of those named.
function(sortie_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;DEPENDS;PRIVATE_DEPENDS;EXCLUDE" ${ARGN})
  set(sources ${ARG_SOURCES})
  if(NOT sources)
    file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  endif()
  list(TRANSFORM sources PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ REGEX "^[^/]")
  foreach(pattern IN LISTS ARG_EXCLUDE)
    list(FILTER sources EXCLUDE REGEX ${pattern})
  endforeach()
  if(NOT sources)  # A folder of headers alone still becomes an archive, so that everyone links it the same way.
    set(sources ${PROJECT_BINARY_DIR}/empty.cpp)
    file(CONFIGURE OUTPUT ${sources} CONTENT "// Nothing here: the folder holds headers alone.\n")
  endif()
  add_library(sortie_${name} STATIC ${sources})
  add_library(Sortie::${name} ALIAS sortie_${name})
  set_target_properties(sortie_${name} PROPERTIES EXPORT_NAME ${name} LINKER_LANGUAGE CXX)
  target_include_directories(sortie_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/sortie>)
  target_link_libraries(sortie_${name} PUBLIC sortie_strict ${ARG_DEPENDS} PRIVATE $<BUILD_INTERFACE:sortie_warnings> ${ARG_PRIVATE_DEPENDS})
  if(SORTIE_JUMBO)
    sortie_batches(sortie_${name} 8)
  endif()
endfunction()

# What the program and the tests, but not the libraries, are compiled with on top: their compilation costs more than
# their run where only tests run.
set(SORTIE_PROGRAM_FLAGS "" CACHE STRING "Compiler flags of firmware_like and tests alone")
