// Meshes with the textures that they name: OBJ with its materials, PLY.
#include "core/io/meshes/scan_file.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto bytes = fuzz::Bytes(data, size);
  fuzz::Put("fox.mtl", bytes);
  fuzz::Put("fox.obj", "mtllib fox.mtl\nv 0 0 0\nvt 0 0\nusemtl fur\nf 1/1 1/1 1/1\n");
  fuzz::Put("own.obj", bytes);
  fuzz::Put("own.ply", bytes);
  for (const char* name : {"fox.obj", "own.obj"})
    fuzz::Expect([&] { ReadScan(fuzz::Folder() / name); });
  return fuzz::Expect([&] { ReadScan(fuzz::Folder() / "own.ply"); });
}
