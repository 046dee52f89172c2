// `keypose armature example`: files of a theropod with 74 sensors, to try everything with.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "armature/armature_commands.h"
#include "armature/description/chain_file.h"
#include "armature/description/description_file.h"
#include "armature/example/theropod.h"
#include "armature/example/theropod_body.h"
#include "armature/example/theropod_set.h"
#include "armature/puppet.h"
#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

namespace fs = std::filesystem;

int WriteExample(const fs::path& folder, int vertices) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw DiskError(fmt::format("cannot make the folder {}: {}", folder.string(), error.message()));
  const Armature theropod = MakeTheropod();
  WriteFile(folder / "theropod.txt",
            "# A theropod with 74 sensors, as large as the largest armature of the paper.\n"
            "# In its zero position spine and legs are straight, at right angles to each other.\n" +
                DescriptionText(theropod));
  WriteFile(folder / "theropod_chains.txt",
            "# Which places armature and computer skeleton share, and the chains between them.\n" +
                ChainsText(theropod, MakeTheropodChains(theropod)));
  WriteBvh(folder / "theropod.bvh", MakeTheropodSkeleton());
  WriteMesh(folder / "theropod.ply", MakeTheropodBody(vertices));
  const FilmedShot shot = MakeTheropodShot(960, 540, 1);
  WriteImage(folder / "plate.png", MakeTheropodPlate(shot));
  WriteFile(folder / "shot.json", ShotText(shot));
  WriteMesh(folder / "set.ply", MakeTheropodSet());
  fmt::print(
      "{0}/theropod.txt         the armature\n{0}/theropod_chains.txt  anchors and chains\n"
      "{0}/theropod.bvh         the computer skeleton\n"
      "{0}/theropod.ply         a body for it\n"
      "{0}/plate.png            a set without it, with its camera (shot.json) and geometry "
      "(set.ply)\n",
      folder.string());
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace

int ExampleCommand(int argc, char** argv) {
  CLI::App app("Writes the files of a generated theropod with 74 sensors.",
               "keypose armature example");
  std::string folder;
  int vertices = 20000;
  app.add_option("--folder", folder, "where to write them")->required();
  app.add_option("--vertices", vertices, "of the body, at least")
      ->check(CLI::Range(1000, 2000000))
      ->capture_default_str();
  return RunCommandLine(app, argc, argv, [&] { return WriteExample(folder, vertices); });
}

}  // namespace keypose::armature
