// Motions as BVH, read and written.
#include "core/io/meshes/bvh_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect([&] { BvhText(ParseBvh(std::string(fuzz::Bytes(data, size)), "clip.bvh")); });
}
