# Stage mesh. PCL without its own package file: that one drags in VTK's.
find_package(PkgConfig REQUIRED)
pkg_check_modules(PCL_COMMON REQUIRED pcl_common)

keypose_room(reconstruct_mesh
  SOURCES mesh_merge.cpp mesh_points.cpp mesh_surface.cpp mesh_trim.cpp mesh_windows.cpp poisson.cpp
  SYSTEM_INCLUDES ${PCL_COMMON_INCLUDE_DIRS}
  LINK keypose_reconstruct_cloud pcl_surface pcl_search pcl_common)
keypose_stage(mesh ROOM reconstruct_mesh SOURCES mesh_stage.cpp prepared_views_stage.cpp LINK keypose_reconstruct_dense nlohmann_json::nlohmann_json)
keypose_test(mesh_test SOURCES mesh_test.cpp mesh_windows_test.cpp LINK keypose_reconstruct_mesh)
