// Cameras as transforms.json, and as Metashape's XML.
#include "core/io/project/poses_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  fuzz::Expect([&] { ReadPoses(fuzz::Put("cameras.xml", fuzz::Bytes(data, size))); });
  return fuzz::Expect([&] { ReadPoses(fuzz::Put("transforms.json", fuzz::Bytes(data, size))); });
}
