// What an OBJ's materials show on it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/meshes/obj_file.h"
#include "core/io/meshes/texture_pages.h"

namespace keypose {

struct ObjLook {
  PagedMesh paged;  ///< without pages: colours of vertices, where there are any
  std::vector<std::filesystem::path> files;  ///< of paged.pictures
  bool moved = false;                        ///< coordinates or colours are not those of the file
  std::vector<std::string> warnings;
};

/// Reads the libraries and the textures that an OBJ names.
/// @param path  of the OBJ
/// @throws DiskError  a file that is there cannot be read
ObjLook LookOfObj(const std::filesystem::path& path, ObjFile obj);

}  // namespace keypose
