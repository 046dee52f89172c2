# Photographs and cameras to a cloud.
find_package(nlohmann_json REQUIRED)

keypose_room(reconstruct_dense
  SOURCES dense.cpp dense_colmap.cpp dense_view.cpp depth_bounds.cpp fusion.cpp gap_fill.cpp hull_fill.cpp mask_field.cpp patch_match.cpp patch_match_cost.cpp
          patch_match_simd.cpp patch_match_sweep.cpp patch_match_warp.cpp rim_cloud.cpp rim_points.cpp silhouettes.cpp view_selection.cpp visual_hull.cpp
          window_bias.cpp
  LINK keypose_reconstruct_cloud)
# A square root that may set errno is a branch and a call.
set_source_files_properties(patch_match_cost.cpp patch_match_simd.cpp patch_match_sweep.cpp patch_match_warp.cpp window_bias.cpp PROPERTIES COMPILE_OPTIONS -fno-math-errno)
keypose_stage(dense ROOM reconstruct_dense SOURCES dense_stage.cpp prepared_views_stage.cpp LINK nlohmann_json::nlohmann_json)

add_library(keypose_dense_test_scene STATIC dense_test_scene.cpp)
target_link_libraries(keypose_dense_test_scene PUBLIC keypose_reconstruct_dense)
keypose_bench(dense_bench SOURCES dense_bench.cpp LINK keypose_dense_test_scene)
keypose_test(dense_test SOURCES dense_test.cpp dense_stage_test.cpp fusion_test.cpp gap_fill_test.cpp patch_match_plane_test.cpp patch_match_test.cpp rim_cloud_test.cpp silhouettes_test.cpp visual_hull_test.cpp window_bias_test.cpp
             LINK keypose_dense_test_scene nlohmann_json::nlohmann_json)
add_dependencies(dense_test keypose-dense)
