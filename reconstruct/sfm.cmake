# Photographs to cameras.
find_package(SQLite3 REQUIRED)
find_package(Ceres REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenCV REQUIRED COMPONENTS core calib3d)

keypose_room(reconstruct_sfm
  SOURCES board_poses.cpp bundle_adjustment.cpp camera_evidence.cpp colmap_database.cpp descriptor_matching.cpp flip.cpp flip_cloud.cpp flip_outlines.cpp flip_shape.cpp guided_matching.cpp known_poses.cpp leveling.cpp outline_ground_stage.cpp pair_list.cpp placed_stage.cpp
    ring_bundle.cpp ring_fit.cpp ring_model.cpp ring_order.cpp ring_picture.cpp ring_sfm.cpp ring_silhouettes.cpp ring_simplex.cpp ring_start.cpp ring_static.cpp ring_tracks.cpp sfm_colmap_stage.cpp sfm_corners.cpp sfm_crop.cpp sfm_hull_check_stage.cpp sfm_ladder_stage.cpp
    sfm_matching_stage.cpp sfm_overlap_stage.cpp sfm_patches.cpp sfm_refine_stage.cpp sfm_thin.cpp sfm_turntable_stage.cpp sfm_verification.cpp upside_down.cpp
  LINK keypose_reconstruct_dense SQLite::SQLite3 Ceres::ceres opencv_core opencv_calib3d nlohmann_json::nlohmann_json
  SYSTEM_INCLUDES ${OpenCV_INCLUDE_DIRS})
set_source_files_properties(descriptor_matching.cpp PROPERTIES COMPILE_OPTIONS -O3)
keypose_stage(sfm ROOM reconstruct_sfm SOURCES sfm_stage.cpp LINK nlohmann_json::nlohmann_json)
keypose_test(ring_test SOURCES ring_test.cpp ring_silhouettes_test.cpp ring_static_test.cpp LINK keypose_reconstruct_sfm)
keypose_test(sfm_test SOURCES sfm_test.cpp sfm_matching_test.cpp sfm_refine_test.cpp LINK keypose_reconstruct_sfm SQLite::SQLite3)
keypose_test(camera_evidence_test SOURCES camera_evidence_test.cpp LINK keypose_reconstruct_sfm)
keypose_test(placed_test SOURCES placed_test.cpp LINK keypose_reconstruct_sfm)
keypose_test(sfm_program_test SOURCES sfm_program_test.cpp LINK keypose_core)
add_dependencies(sfm_program_test keypose-sfm)
if(TARGET keypose-capture)
  add_dependencies(sfm_program_test keypose-capture)
endif()
