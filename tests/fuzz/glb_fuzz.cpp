// Meshes and textures of glTF.
#include "core/io/meshes/scan_file.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto file = fuzz::Put("a.glb", fuzz::Bytes(data, size));
  return fuzz::Expect([&] { ReadScan(file); });
}
