keypose_room(texture_unwrap SOURCES bake_max_flow.cpp charts.cpp charts_hide.cpp packing.cpp packing_contact.cpp packing_press.cpp packing_search.cpp parametrise.cpp parametrise_sheet.cpp unwrap.cpp unwrap_atlas.cpp unwrap_check.cpp)
keypose_stage(unwrap ROOM texture_unwrap SOURCES unwrap_stage.cpp)
keypose_test(unwrap_test SOURCES unwrap_test.cpp LINK keypose_texture_unwrap)
