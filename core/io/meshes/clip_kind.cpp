#include "core/io/meshes/clip_kind.h"

#include <array>
#include <cstdint>

namespace keypose {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::size_t kLooked = 4096;  // bytes
constexpr const char* kInBlender =
    "; import it into Blender, and export what it moves by File, Export, Motion Capture (.bvh)";
constexpr const char* kOfMarkers =
    ": places of markers, not turns of a skeleton; solve them onto one in the program that "
    "recorded them, and export BVH";

struct ClipMark {
  std::string_view text;
  bool first;  ///< it stands at the file's beginning
  const char* kind;
  const char* cure;
};

constexpr std::array kMarks{
    ClipMark{"Kaydara FBX Binary", true, "FBX", kInBlender},
    ClipMark{"; FBX ", true, "FBX", kInBlender},
    ClipMark{"PathFileType", true, "TRC", kOfMarkers},
    ClipMark{"FileType htr", false, "HTR", "; export BVH from the program that recorded it"},
    ClipMark{":FULLY-SPECIFIED", false, "AMC",
             ": the motion of a skeleton that is in an .asf file; convert the two together to BVH"},
    ClipMark{":bonedata", false, "ASF",
             ": a skeleton, whose motion is in .amc files; convert the two together to BVH"},
    ClipMark{"glTF", true, "GLB", kInBlender},
    ClipMark{"<COLLADA", false, "COLLADA", kInBlender},
    ClipMark{"PXR-USDC", true, "USD", kInBlender},
    ClipMark{"#usda", true, "USD", kInBlender},
    ClipMark{"Ogawa", true, "Alembic", ": places of vertices; export the skeleton's motion as BVH"},
    ClipMark{"BLENDER", true, "a Blender file", "; export it there as Motion Capture (.bvh)"},
    ClipMark{"Vocaloid Motion Data", true, "VMD", "; convert it to BVH"},
    ClipMark{"PK\3\4"sv, true, "a ZIP or NPZ file",
             "; unpack it, and give the BVH file that is in it"},
    ClipMark{"\x1f\x8b"sv, true, "packed by gzip", "; unpack it"}};

}  // namespace

std::string OtherClip(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, kLooked);
  // The first byte says where the parameters are.
  if (head.size() > 4 && head[0] > 0 && head[0] < 32 && head[1] == 0x50)
    return std::string("is C3D") + kOfMarkers;
  for (const ClipMark& mark : kMarks)
    if (mark.first ? head.starts_with(mark.text) : head.find(mark.text) != std::string_view::npos)
      return std::string("is ") + mark.kind + mark.cure;
  return "";
}

}  // namespace keypose
