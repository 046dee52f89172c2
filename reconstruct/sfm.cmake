# Photographs to cameras.
find_package(SQLite3 REQUIRED)
find_package(Ceres REQUIRED)
find_package(nlohmann_json REQUIRED)

keypose_room(reconstruct_sfm
  SOURCES bundle_adjustment.cpp colmap_database.cpp descriptor_matching.cpp guided_matching.cpp leveling.cpp pair_list.cpp sfm_colmap_stage.cpp
  LINK SQLite::SQLite3 Ceres::ceres)
set_source_files_properties(descriptor_matching.cpp PROPERTIES COMPILE_OPTIONS -O3)
keypose_stage(sfm ROOM reconstruct_sfm SOURCES sfm_stage.cpp LINK nlohmann_json::nlohmann_json)
keypose_test(sfm_test SOURCES sfm_test.cpp LINK keypose_reconstruct_sfm SQLite::SQLite3)
keypose_test(sfm_program_test SOURCES sfm_program_test.cpp LINK keypose_core)
add_dependencies(sfm_program_test keypose-sfm)
if(TARGET keypose-capture)
  add_dependencies(sfm_program_test keypose-capture)
endif()
