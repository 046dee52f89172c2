// Masks that people drew, and colour profiles.
#include "core/io/pictures/color_profile.h"
#include "core/io/pictures/drawn_mask.h"
#include "core/io/pictures/image_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  constexpr std::int64_t kManyPixels = 1 << 20;  // larger images would be slow, not wrong
  const auto bytes = fuzz::Bytes(data, size);
  fuzz::Expect([&] { InSrgb(Image8(2, 2, 3), std::string(bytes)); });
  return fuzz::Expect([&] {
    const auto path = fuzz::Put("mask", bytes);
    const ImageInfo info = ReadImageInfo(path);
    if (std::int64_t{info.width} * info.height <= kManyPixels) ReadDrawnMask(path);
  });
}
