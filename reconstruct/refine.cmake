# The surface against the photographs.
keypose_room(reconstruct_refine
  SOURCES refine.cpp refine_claims.cpp refine_outlines.cpp refine_profile.cpp refine_shading.cpp refine_solve.cpp refine_views.cpp
  LINK keypose_reconstruct_dense)
keypose_stage(refine ROOM reconstruct_refine SOURCES prepared_views_stage.cpp refine_stage.cpp LINK nlohmann_json::nlohmann_json)
keypose_test(refine_test SOURCES refine_test.cpp refine_outlines_test.cpp LINK keypose_reconstruct_refine keypose_dense_test_scene)
