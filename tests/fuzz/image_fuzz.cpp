// Photographs of all formats, recognised by content.
#include "core/io/pictures/image_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  constexpr std::int64_t kManyPixels = 1 << 22;  // larger images would be slow, not wrong
  return fuzz::Expect([&] {
    const auto path = fuzz::Put("image", fuzz::Bytes(data, size));
    const ImageInfo info = ReadImageInfo(path);
    if (std::int64_t{info.width} * info.height <= kManyPixels) ReadImage(path, 3);
  });
}
