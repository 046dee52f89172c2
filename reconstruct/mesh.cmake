# Stage mesh. PCL without its own package file: that one drags in VTK's.
find_package(PkgConfig REQUIRED)
pkg_check_modules(PCL_COMMON REQUIRED pcl_common)

keypose_room(reconstruct_mesh
  SOURCES mesh_merge.cpp mesh_points.cpp mesh_surface.cpp mesh_trim.cpp poisson.cpp
  SYSTEM_INCLUDES ${PCL_COMMON_INCLUDE_DIRS}
  LINK keypose_reconstruct_cloud pcl_surface pcl_search pcl_common)
keypose_stage(mesh ROOM reconstruct_mesh SOURCES mesh_stage.cpp)
keypose_test(mesh_test SOURCES mesh_test.cpp LINK keypose_reconstruct_mesh)
