# Photographs and cameras to a cloud.
find_package(nlohmann_json REQUIRED)

keypose_room(reconstruct_dense
  SOURCES dense.cpp dense_colmap.cpp dense_view.cpp depth_bounds.cpp fusion.cpp patch_match.cpp patch_match_cost.cpp patch_match_sweep.cpp
          view_selection.cpp visual_hull.cpp)
keypose_stage(dense ROOM reconstruct_dense SOURCES dense_stage.cpp LINK nlohmann_json::nlohmann_json)
