find_package(nlohmann_json REQUIRED)

keypose_room(texture_bake SOURCES
    bake.cpp bake_align.cpp bake_atlas.cpp bake_consensus.cpp bake_gain.cpp bake_labels.cpp max_flow.cpp bake_paint.cpp bake_quality.cpp bake_seams.cpp
    bake_split.cpp bake_view.cpp bake_votes.cpp complete.cpp)
keypose_stage(bake ROOM texture_bake SOURCES bake_stage.cpp LINK nlohmann_json::nlohmann_json)
keypose_stage(complete ROOM texture_bake SOURCES complete_stage.cpp)
keypose_test(complete_test SOURCES complete_test.cpp LINK keypose_texture_bake)
keypose_test(bake_test SOURCES bake_test.cpp bake_consensus_test.cpp bake_parts_test.cpp LINK keypose_texture_bake)
add_dependencies(bake_test keypose-bake)
