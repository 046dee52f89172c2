// Meshes and textures of binary glTF.
#include "core/io/meshes/glb_mesh.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto file = fuzz::Put("a.glb", fuzz::Bytes(data, size));
  return fuzz::Expect([&] { ReadGlb(file); });
}
