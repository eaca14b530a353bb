set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(TESSERA_CCACHE ccache)
if(TESSERA_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # Paths are made relative and the build folder is left out of the hash, so that another checkout finds these objects.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR}
      CCACHE_NOHASHDIR=1 CCACHE_SLOPPINESS=include_file_mtime,include_file_ctime,time_macros ${TESSERA_CCACHE})
endif()

set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
# -g1: line numbers for backtraces, at a third of the size and time of -g.
set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O2 -g1 -DNDEBUG")

add_library(tessera_options INTERFACE)
target_include_directories(tessera_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(tessera_options INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Woverloaded-virtual
  -Wnull-dereference -Wimplicit-fallthrough -Wno-missing-field-initializers
  # The exactness contract: one instruction set, no contraction of a*b+c, no -ffast-math.
  -march=x86-64-v3 -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # g++ 12 gathers a − b and a + b into one contracted instruction (vfmaddsub) where it makes vectors of straight lines of code,
  # whatever -ffp-contract says. tests/unit/house reads the worker for such instructions.
  target_compile_options(tessera_options INTERFACE -fno-tree-slp-vectorize)
  # g++'s flow analysis finds null dereferences inside libstdc++ and Asio that are not there; and it takes the operator delete
  # of coroutines' frames, and Asio's aligned allocation, for mismatches when it inlines them. At -O3 version 12 also sees
  # overlapping copies in std::string's operator+ (GCC bug 105651) and overflows within fmt.
  target_compile_options(tessera_options INTERFACE -Wno-null-dereference -Wno-mismatched-new-delete -Wno-restrict
    -Wno-stringop-overflow)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 16)
  # Clang 14 has coroutines and does not say so in the way that Asio asks.
  target_compile_definitions(tessera_options INTERFACE BOOST_ASIO_HAS_CO_AWAIT=1 BOOST_ASIO_HAS_STD_COROUTINE=1)
endif()
if(TESSERA_WERROR)
  target_compile_options(tessera_options INTERFACE -Werror)
endif()
if(TESSERA_ASSERTS)
  target_compile_options(tessera_options INTERFACE -UNDEBUG)
endif()
if(TESSERA_SANITIZE)
  # -O1: the tests take a little longer, their build much less.
  set(CMAKE_CXX_FLAGS_RELWITHDEBINFO "-O1 -g1 -DNDEBUG")
  add_compile_options(-fsanitize=${TESSERA_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${TESSERA_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    # It takes calls into libraries that were not built with it for faults.
    add_compile_options(-fno-sanitize=function)
  else()
    # g++ sees false "maybe uninitialized" under the sanitizers' instrumentation.
    add_compile_options(-Wno-maybe-uninitialized)
  endif()
endif()

if(TESSERA_FUZZ)
  # Every edge that an input takes is counted, which leads libFuzzer on.
  add_compile_options(-fsanitize=fuzzer-no-link)
  add_link_options(-fsanitize=fuzzer-no-link)
endif()

# tessera_library(name SOURCES… [PUBLIC libs…] [PRIVATE libs…]): one folder, one static library.
function(tessera_library name)
  cmake_parse_arguments(A "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(${name} STATIC ${A_SOURCES})
  target_link_libraries(${name} PUBLIC tessera_options ${A_PUBLIC} PRIVATE ${A_PRIVATE})
endfunction()

# What ThreadSanitizer looks at: tests with the label `threads`, and what they need.
add_custom_target(threaded_tests)

# tessera_test(name SOURCES… LIBS… [LABELS…] [TIMEOUT s]): one gtest binary, one ctest entry per binary.
function(tessera_test name)
  cmake_parse_arguments(A "" "TIMEOUT" "SOURCES;LIBS;LABELS" ${ARGN})
  add_executable(${name} ${A_SOURCES})
  target_link_libraries(${name} PRIVATE tessera_options ${A_LIBS} GTest::gmock GTest::gtest_main)
  if("threads" IN_LIST A_LABELS)
    add_dependencies(threaded_tests ${name})
  endif()
  if(NOT A_TIMEOUT)
    set(A_TIMEOUT 600)
  endif()
  add_test(NAME ${name} COMMAND ${name})
  set_tests_properties(${name} PROPERTIES TIMEOUT ${A_TIMEOUT} LABELS "${A_LABELS}"
    ENVIRONMENT "TESSERA_SOURCE_DIR=${CMAKE_SOURCE_DIR};TESSERA_BIN_DIR=${CMAKE_RUNTIME_OUTPUT_DIRECTORY};TSAN_OPTIONS=ignore_noninstrumented_modules=1 suppressions=${CMAKE_SOURCE_DIR}/tests/tsan.supp;UBSAN_OPTIONS=print_stacktrace=1")
endfunction()
