// Files that other programs call a mesh, a cloud or a scene, and that are not read: what they are,
// and how to get a mesh from them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace keypose {

struct OtherMesh {
  std::string kind;  ///< "an FBX file"; empty: not known
  std::string cure;  ///< what to do
};

/// By the first bytes.
/// @param head  the first 4096 bytes, or all
OtherMesh OtherMeshOf(std::string_view head);

/// By the ending of its name.
OtherMesh OtherMeshNamed(const std::filesystem::path& file);

/// Whether a text is in UTF-16, which none of the formats that are read may be in.
bool IsUtf16(std::string_view head);

}  // namespace keypose
