// Files that a page sends in pieces, as films are larger than what one request holds: each goes to
// the folder that its kind has in the project.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace keypose::studio {

struct UploadPiece {
  /// - shot         films of a performance's shot: a video, or CAMERA/PICTURE, background/PICTURE,
  ///                masks/CAMERA/PICTURE
  /// - calibration  of a performance's cameras: calibration.ENDING of the project
  /// - scan         scan/: a mesh or a texture
  /// - film         films/: a video, or FOLDER/PICTURE
  /// - armature     armature/: a puppet's files
  std::string place;
  std::string shot;  ///< of the first kind
  std::string name;
  std::uint64_t at = 0;    ///< byte of the file with which the piece begins
  std::uint64_t size = 0;  ///< of the whole file
};

struct Upload {
  std::uint64_t sent =
      0;             ///< bytes of it that are here; a piece that begins elsewhere is not taken
  std::string file;  ///< its path in the project, once all of it is here; else ""
};

/// Takes a piece; with the last one the file goes to its place.
/// @throws UsageError  a place or name that there is not, another file of that name, a kind of file
/// that cannot be read there
/// @throws DiskError   it cannot be written
Upload TakePiece(const std::filesystem::path& project, const UploadPiece& piece,
                 const std::string& bytes);

}  // namespace keypose::studio
