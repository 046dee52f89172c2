// PLY point clouds.
#include "tests/fuzz/fuzz_folder.h"
#include "core/io/mesh_io.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect([&] { ReadPointCloud(fuzz::Put("cloud.ply", fuzz::Bytes(data, size))); });
}
