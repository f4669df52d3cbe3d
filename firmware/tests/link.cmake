# Tests of the link: the app on a bench board, and fuzzing of parser and orders.
enable_testing()
add_library(bench INTERFACE)
target_sources(bench INTERFACE ${CMAKE_CURRENT_LIST_DIR}/../app/vehicle/controller.cpp ${CMAKE_CURRENT_LIST_DIR}/../app/radio/radio.cpp)
target_link_libraries(bench INTERFACE core mavlink)
target_include_directories(bench INTERFACE ${CMAKE_CURRENT_LIST_DIR}/..)
target_compile_definitions(bench INTERFACE HYPERTUNA_ROBOT="${robot_header}")
target_compile_options(bench INTERFACE -O1 -fno-rtti -ffp-contract=off)

add_executable(link_bench ${CMAKE_CURRENT_LIST_DIR}/link_bench.cpp)
target_link_libraries(link_bench PRIVATE bench)

add_executable(test_link ${CMAKE_CURRENT_LIST_DIR}/test_link.cpp)
target_link_libraries(test_link PRIVATE bench)
add_test(NAME test_link COMMAND test_link)

# libFuzzer comes with clang: -DCMAKE_CXX_COMPILER=clang++ -DHYPERTUNA_SANITIZE=ON, then fuzz_link -max_total_time=600.
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  add_executable(fuzz_link ${CMAKE_CURRENT_LIST_DIR}/fuzz_link.cpp)
  target_link_libraries(fuzz_link PRIVATE bench)
  target_compile_options(fuzz_link PRIVATE -g1 -fsanitize=fuzzer)
  target_link_options(fuzz_link PRIVATE -fsanitize=fuzzer)
endif()
