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

void Append(std::uint32_t letter, std::string* text) {
  const auto put = [&](std::uint32_t byte) { text->push_back(static_cast<char>(byte)); };
  if (letter < 0x80) return put(letter);
  if (letter < 0x800) {
    put(0xc0 | letter >> 6);
  } else {
    if (letter < 0x10000) {
      put(0xe0 | letter >> 12);
    } else {
      put(0xf0 | letter >> 18);
      put(0x80 | (letter >> 12 & 0x3f));
    }
    put(0x80 | (letter >> 6 & 0x3f));
  }
  put(0x80 | (letter & 0x3f));
}

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

std::string FromUtf16(std::string_view bytes) {
  if (bytes.size() < 2) return "";
  const bool marked = bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv);
  if (!marked && (bytes[0] == 0) == (bytes[1] == 0)) return "";
  const std::size_t high = bytes.starts_with("\xfe\xff"sv) || bytes[0] == 0 ? 0 : 1;
  const auto unit = [&](std::size_t at) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + high]) << 8 |
                                      static_cast<unsigned char>(bytes[at + 1 - high]));
  };
  std::string text;
  for (std::size_t at = marked ? 2 : 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t letter = unit(at);
    const bool pair = letter >= 0xd800 && letter < 0xdc00 && at + 3 < bytes.size() &&
                      (unit(at + 2) & 0xfc00) == 0xdc00;
    if (pair) {
      at += 2;
      letter = 0x10000 + ((letter & 0x3ff) << 10 | (unit(at) & 0x3ff));
    }
    Append(letter, &text);
  }
  return text;
}

}  // namespace keypose
