#include "export/how_to_open.h"

#include <fmt/format.h>

#include <map>

namespace keypose::exporting {
namespace {

constexpr char kGlbInBlender[] =
    "Blender: File > Import > glTF 2.0. In Debian 12's Blender 3.4 set Shading to Smooth in the "
    "import dialogue. This is not a matter of taste: with \"Use Normal Data\" the import stops "
    "with \"module 'numpy' has no attribute 'bool'\", whatever the file, since that Blender is "
    "older than Debian's numpy.";

constexpr char kCache[] =
    "A point cache and the mesh it belongs to. The format `blender` does all of this by itself "
    "(blender/keypose_import.py). By hand: File > Import > Wavefront (.obj) with "
    "cache/character.obj; add a Mesh Cache modifier with {}, Format {}; Frame Start 1. All else "
    "as it is: the mesh numbers its vertices as Blender's importers do.";

/// {fps} is filled in.
const std::map<std::string, std::string>& Paragraphs() {
  static const std::map<std::string, std::string> paragraphs = {
      {"glb",
       std::string("character.glb\nPhones, browsers, game engines: as it is. ") + kGlbInBlender},
      {"glb-full",
       std::string("character_full.glb\nEvery picture is a morph target. ") + kGlbInBlender},
      {"glb-few", std::string("character_few.glb\nFor engines that blend few targets. ") +
                      kGlbInBlender + " Set the frame rate to {fps:g} before."},
      {"video", "character.mp4, character.gif, character_turntable.mp4\nFilms: open them."},
      {"sheet",
       "character_sheet.html\nThe exposure sheet, a row for each picture: open it in a browser, "
       "and "
       "print it on A4."},
      {"obj",
       "obj/\nBlender with Stop-motion-OBJ: File > Import > Mesh Sequence, File Name `frame`, "
       "leave "
       "the axes; set the frame rate to {fps:g}. One file is one picture of the film."},
      {"ply",
       "ply/\nBlender with Stop-motion-OBJ: File > Import > Mesh Sequence, File Name `frame`, Y "
       "Forward, Z Up; set the frame rate to {fps:g}. One file is one picture of the film."},
      {"fbx",
       "character.fbx\nBlender: File > Import > FBX; the animation begins at frame 1. Unity: drop "
       "it "
       "into Assets, Model > Blend Shape Normals: Import. Unreal: import as Skeletal Mesh with "
       "Import Morph Targets and Convert Scene Unit."},
      {"pc2", std::string("cache/character.pc2\n") +
                  fmt::format(kCache, "cache/character.pc2", "PC2") +
                  " Set the frame rate to {fps:g}."},
      {"mdd", std::string("cache/character.mdd\n") +
                  fmt::format(kCache, "cache/character.mdd", "MDD") +
                  " Set the frame rate to {fps:g}."},
      {"vat", "vat/\nGodot, Unity, three.js: by a shader; docs/vertex-animation-textures.md."},
      {"usda",
       "character.usda\nusdview, Houdini, Maya, Omniverse. three.js shows its first picture, "
       "still, "
       "because its loader reads no time samples: take character.glb there. Debian's Blender reads "
       "no USD."},
      {"blender",
       "blender/\nBlender: Edit > Preferences > Add-ons > Install, blender/keypose_import.py, tick "
       "its box; then File > Import > Keypose project, the project's folder."}};
  return paragraphs;
}

}  // namespace

std::string HowToOpen(const std::vector<std::string>& formats, double fps) {
  std::string text = "How to open these files. +y is up, a unit is a metre.\n";
  for (const std::string& format : formats)
    text += "\n" + fmt::format(fmt::runtime(Paragraphs().at(format)), fmt::arg("fps", fps)) + "\n";
  return text;
}

}  // namespace keypose::exporting
