// Which files are photographs that Keypose reads, judged by their names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose {

/// The extensions that are read, for messages.
inline const char* const kReadablePhotographs =
    ".jpg, .jpeg, .jfif, .png, .tif, .tiff, .heic, .heif, .hif";
/// Those of RAW files, which `capture` develops where there are no others.
inline const char* const kReadableRaw = ".cr2, .cr3, .nef, .arw, .dng, .raf, .orf, .rw2";

/// @return whether the name's extension (any case) is one of kReadablePhotographs
bool IsPhotographName(const std::filesystem::path& file);
/// Whether the extension is one of HEIC and HEIF, which phones write.
bool IsHeicName(const std::filesystem::path& file);
/// Whether the extension (any case) is one of .cr2 .cr3 .nef .arw .dng .raf .orf .rw2: RAW files
/// that core/io/pictures/raw_io.h develops.
bool IsRawName(const std::filesystem::path& file);
/// The name under which `capture` writes a photograph. HEIC and RAW become .jpg, because no later
/// stage reads them; .jfif is JPEG under a name that not every program knows.
std::string WrittenName(const std::filesystem::path& file);
/// Whether the file or folder is one that operating systems, file managers and disk stations
/// create: hidden ones, Thumbs.db, desktop.ini, @eaDir, __MACOSX.
bool IsLitterName(const std::filesystem::path& file);

/// What `keypose shoot` writes beside the photographs of a pose: its notes, and a folder with the
/// pictures that each photograph was merged from.
inline constexpr const char* kShootNotes = "shoot.json";
inline constexpr const char* kFocusStacks = "stacks";
/// Whether a photograph is one of the empty set: background.jpg, Background.CR2, ...
bool IsCleanPlateName(const std::filesystem::path& file);
/// Whether a file of a pose's folder is a photograph of the figure, RAW or not. `capture` reads the
/// folder and the folders in it.
/// @param file  relative to the pose's folder
bool IsShotName(const std::filesystem::path& file);

/// Whether the extension (any case) is one of a mesh's: .obj .ply .off .stl, or a format that is
/// not read, such as .glb.
bool IsMeshName(const std::filesystem::path& file);
/// Whether the extension (any case) is one of the meshes that stages read: .obj .ply .off .stl .glb
/// .gltf.
bool IsReadableMeshName(const std::filesystem::path& file);
inline constexpr const char* kHowToNameMeshes =
    "for meshes made elsewhere, name each file itself, as in --pose rest=rest.obj --pose "
    "wave=wave.ply";

/// A summary by extension, such as "12 .mov (IMG_1.mov, IMG_2.mov ...), 1 .txt (notes.txt)"; empty
/// for no files.
/// @param files  only their names are used
std::string KindsOf(const std::vector<std::filesystem::path>& files);
/// Advice for files of kinds that are not read, such as "develop RAW files to JPEG"; may be empty.
std::string CureFor(const std::vector<std::filesystem::path>& files);

}  // namespace keypose
