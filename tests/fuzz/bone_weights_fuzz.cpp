// Weights of bones: JSON and .dmat.
#include "core/io/meshes/bone_weights.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  return fuzz::Expect([&] {
    ParseBoneWeights(std::string(fuzz::Bytes(data, size)), "weights", {"hip", "knee"}, 5);
  });
}
