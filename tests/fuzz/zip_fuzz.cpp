// ZIP files of scanning apps.
#include "core/io/meshes/scan_file.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto file = fuzz::Put("a.zip", fuzz::Bytes(data, size));
  return fuzz::Expect([&] { ReadScan(file); });
}
