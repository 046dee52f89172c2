// What Keypose notes beside pictures and frames: painted.json of masks, distortion.json of frames.
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/painted_masks.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const auto bytes = fuzz::Bytes(data, size);
  fuzz::Expect([&] {
    fuzz::Put(kPaintedNotes, bytes);
    WritePaintedMasks(fuzz::Folder(), ReadPaintedMasks(fuzz::Folder()));
  });
  fuzz::Put("distortion.json", bytes);
  fuzz::Expect([&] { FrameRateOf(fuzz::Folder()); });
  return fuzz::Expect([&] { ReadFrameTimes(fuzz::Folder(), 3); });
}
