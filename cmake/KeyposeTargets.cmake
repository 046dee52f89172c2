# Helpers that every room's CMakeLists.txt uses: keypose_room, keypose_stage, keypose_test, keypose_bench.
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)

add_library(keypose_flags INTERFACE)
target_include_directories(keypose_flags INTERFACE ${CMAKE_SOURCE_DIR})
option(KEYPOSE_FUZZ "libFuzzer programs for the readers; see tests/fuzz" OFF)
# Constants of core/values/tuned.h can be set from outside; only for bench/sensitivity.py.
option(KEYPOSE_SENSITIVITY "tuned constants can be replaced by an environment variable" OFF)
if(KEYPOSE_SENSITIVITY)
  target_compile_definitions(keypose_flags INTERFACE KEYPOSE_SENSITIVITY)
endif()
# Clang, which makes the sanitizers' and fuzz programs, has warnings of its own that are not kept clean here.
# Contraction off: a fused multiply-add would give other bits on other processors.
target_compile_options(keypose_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor $<IF:$<CXX_COMPILER_ID:Clang>,-w,-Werror> -ffp-contract=off)
target_link_libraries(keypose_flags INTERFACE Eigen3::Eigen Threads::Threads)
# Each function in a section of its own, and none kept that a program does not call: then libraries which only those
# need are not loaded either. A mesh stage starts in a tenth of the time without the image libraries.
target_compile_options(keypose_flags INTERFACE -ffunction-sections -fdata-sections)
target_link_options(keypose_flags INTERFACE -Wl,--as-needed -Wl,--gc-sections)
# lld looks at what is kept before it says which libraries are needed; bfd and gold look before, and would load them all.
target_link_options(keypose_flags INTERFACE -fuse-ld=lld)
find_program(KEYPOSE_CCACHE ccache)
if(KEYPOSE_CCACHE)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
      CCACHE_SLOPPINESS=pch_defines,time_macros ${KEYPOSE_CCACHE})
endif()

# With this on, a room's sources are compiled sixteen at a time: most of a source's time goes to the headers that it shares with its neighbours
# (docs/decisions/sources-in-batches.md), and so are a test's. A source with flags of its own stays alone. OFF: each source by itself.
option(KEYPOSE_BATCHES "compile the sources of a room in batches" OFF)

# keypose_room(NAME [FILES] [WORDS] SOURCES a.cpp ... [LINK lib ...] [SYSTEM_INCLUDES dir ...])
# A room or sub-room: one static library keypose_NAME of one concern. LINK stays private to its sources; the
# keypose_ targets in it are all that they may include besides core, and only those with FILES, and programs,
# touch files. tests/include_rule_test.cpp holds the sources to both, by build/PRESET/rooms.txt.
function(keypose_room name)
  cmake_parse_arguments(ARG "FILES;WORDS" "" "SOURCES;LINK;SYSTEM_INCLUDES" ${ARGN})
  add_library(keypose_${name} STATIC ${ARG_SOURCES})
  set_target_properties(keypose_${name} PROPERTIES UNITY_BUILD ${KEYPOSE_BATCHES} UNITY_BUILD_BATCH_SIZE 16)
  if(KEYPOSE_BATCHES)  # a batch includes its sources, and the warning takes what is included for a header
    target_compile_options(keypose_${name} PRIVATE -Wno-subobject-linkage)
  endif()
  if(ARG_WORDS)
    target_compile_options(keypose_${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  target_link_libraries(keypose_${name} PUBLIC keypose_flags PRIVATE ${ARG_LINK})
  target_include_directories(keypose_${name} SYSTEM PRIVATE ${ARG_SYSTEM_INCLUDES})
  if(NOT CMAKE_CURRENT_SOURCE_DIR MATCHES "^${CMAKE_SOURCE_DIR}/core/")
    target_link_libraries(keypose_${name} PUBLIC keypose_core)
  endif()
  list(FILTER ARG_LINK INCLUDE REGEX "^keypose_")
  cmake_path(RELATIVE_PATH CMAKE_CURRENT_SOURCE_DIR BASE_DIRECTORY ${CMAKE_SOURCE_DIR} OUTPUT_VARIABLE folder)
  string(JOIN " " line keypose_${name} ${folder} $<IF:$<BOOL:${ARG_FILES}>,files,values> ${ARG_LINK})
  set_property(GLOBAL APPEND PROPERTY KEYPOSE_ROOM_LINES "${line}")
endfunction()

# keypose_write_rooms(): all rooms in rooms.txt, a line each: target, folder, "files" or "values", linked rooms.
function(keypose_write_rooms)
  get_property(lines GLOBAL PROPERTY KEYPOSE_ROOM_LINES)
  list(JOIN lines "\n" text)
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/rooms.txt CONTENT "${text}\n")
endfunction()

# All that a person runs, without tests and benchmarks: what ./dev demo and ./dev build make, and what is installed.
add_custom_target(programs)

# keypose_program(NAME): a program that a person or the runner starts.
function(keypose_program name)
  add_dependencies(programs ${name})
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endfunction()

# keypose_late_library(NAME SOURCES a.cpp [LINK lib ...] [SYSTEM_INCLUDES dir ...]): lib/keypose/keypose_NAME.so, which programs load
# when they need it (core/values/late_library.h). The room that loads it depends on it and does not link it.
function(keypose_late_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;SYSTEM_INCLUDES" ${ARGN})
  add_library(keypose_${name} MODULE ${ARG_SOURCES})
  set_target_properties(keypose_${name} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/lib/keypose
    CXX_VISIBILITY_PRESET hidden)
  target_link_libraries(keypose_${name} PRIVATE keypose_flags ${ARG_LINK})
  target_include_directories(keypose_${name} SYSTEM PRIVATE ${ARG_SYSTEM_INCLUDES})
  add_dependencies(programs keypose_${name})
  install(TARGETS keypose_${name} LIBRARY DESTINATION ${CMAKE_INSTALL_BINDIR}/../lib/keypose)
endfunction()

# keypose_stage(STAGE ROOM room SOURCES stage.cpp): the program bin/keypose-STAGE.
function(keypose_stage stage)
  cmake_parse_arguments(ARG "" "ROOM" "SOURCES;LINK" ${ARGN})
  add_executable(keypose-${stage} ${ARG_SOURCES})
  set_target_properties(keypose-${stage} PROPERTIES UNITY_BUILD ${KEYPOSE_BATCHES})
  target_link_libraries(keypose-${stage} PRIVATE keypose_${ARG_ROOM} ${ARG_LINK})
  keypose_program(keypose-${stage})
endfunction()

# Whoever builds the programs alone needs neither GoogleTest nor Google Benchmark.
option(KEYPOSE_TESTS "tests and benchmarks can be built too" ON)
if(KEYPOSE_TESTS)
  find_package(GTest REQUIRED)
  find_package(benchmark REQUIRED)
  set(KEYPOSE_GTEST GTest::gmock GTest::gtest_main)
  set(KEYPOSE_BENCHMARK benchmark::benchmark_main)
endif()

# How many times as long the sanitizers' tests may take.
set(KEYPOSE_SLOWER 1)
if(CMAKE_BUILD_TYPE STREQUAL "Debug" AND CMAKE_CXX_FLAGS_DEBUG MATCHES "KEYPOSE_SANITIZED")
  set(KEYPOSE_SLOWER 12)
endif()

# keypose_test(NAME SOURCES foo_test.cpp ... [LINK keypose_room ...] [LABELS full] [FULL] [COST SECONDS]): a GoogleTest program known to
# ctest, one ctest entry a program. LABELS full: only `./dev test --full` runs it. FULL: that holds for its suites whose names end in Full,
# which are an entry of their own, NAME_full. COST: of the longest, so that they begin first where no test has run yet.
function(keypose_test name)
  cmake_parse_arguments(ARG "FULL" "TIMEOUT;COST" "SOURCES;LINK;LABELS;SYSTEM_INCLUDES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${KEYPOSE_BATCHES} UNITY_BUILD_BATCH_SIZE 16)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  if(KEYPOSE_BATCHES)
    target_compile_options(${name} PRIVATE -Wno-subobject-linkage)
  endif()
  target_include_directories(${name} SYSTEM PRIVATE ${ARG_SYSTEM_INCLUDES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} keypose_testing_paths ${KEYPOSE_GTEST})
  set(entries ${name})
  if(ARG_FULL)
    add_test(NAME ${name} COMMAND ${name} --gtest_filter=-*Full.*)
    add_test(NAME ${name}_full COMMAND ${name} --gtest_filter=*Full.*)
    list(APPEND entries ${name}_full)
  else()
    add_test(NAME ${name} COMMAND ${name})
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 900)
  endif()
  math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * ${KEYPOSE_SLOWER}")
  # Debian's python3, also where another stands first: Blender takes the libraries of the first.
  set_tests_properties(${entries} PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}"
    ENVIRONMENT_MODIFICATION "PATH=path_list_prepend:/usr/bin")
  if(ARG_COST)
    set_tests_properties(${name} PROPERTIES COST ${ARG_COST})
  endif()
  if(ARG_FULL)
    set_tests_properties(${name}_full PROPERTIES LABELS full)
  endif()
endfunction()

# keypose_bench(NAME SOURCES foo_bench.cpp ... LINK keypose_room ...): a Google Benchmark program, run by ./dev bench.
function(keypose_bench name)
  cmake_parse_arguments(ARG "" "" "SOURCES;LINK;SYSTEM_INCLUDES" ${ARGN})
  add_executable(${name} ${ARG_SOURCES})
  target_include_directories(${name} SYSTEM PRIVATE ${ARG_SYSTEM_INCLUDES})
  target_link_libraries(${name} PRIVATE ${ARG_LINK} ${KEYPOSE_BENCHMARK})
  set_property(GLOBAL APPEND PROPERTY KEYPOSE_BENCHES ${name})
endfunction()

# keypose_npm_packages(): the packages of package-lock.json in node_modules, for the rooms that bundle a page.
function(keypose_npm_packages)
  set(lock ${CMAKE_SOURCE_DIR}/package-lock.json)
  set(installed ${CMAKE_SOURCE_DIR}/node_modules/.package-lock.json)
  if(NOT EXISTS ${installed} OR ${lock} IS_NEWER_THAN ${installed})
    message(STATUS "Installing the npm packages of package-lock.json")
    execute_process(COMMAND npm ci --no-audit --no-fund --silent WORKING_DIRECTORY ${CMAKE_SOURCE_DIR} COMMAND_ERROR_IS_FATAL ANY)
  endif()
endfunction()
