// PLY point clouds.
#include "core/io/meshes/mesh_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect([&] { ReadPointCloud(fuzz::Put("cloud.ply", fuzz::Bytes(data, size))); });
}
