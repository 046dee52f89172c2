// RAW files of cameras.
#include "core/io/pictures/raw_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  constexpr std::int64_t kManyPixels = 1 << 18;  // larger images would be slow, not wrong
  return fuzz::Expect([&] {
    const auto path = fuzz::Put("a.dng", fuzz::Bytes(data, size));
    const ImageInfo info = ReadRawInfo(path);
    if (std::int64_t{info.width} * info.height <= kManyPixels) ReadRaw(path);
  });
}
