// capture.json of an images folder.
#include "core/io/pictures/image_set.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  fuzz::Put("a.jpg", "x");
  return fuzz::Expect([&] {
    fuzz::Put("capture.json", fuzz::Bytes(data, size));
    WriteImageSet(ReadImageSet(fuzz::Folder()));
  });
}
