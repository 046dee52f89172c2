// shot.json of a filmed shot, read and written, and the numbers in pictures' names.
#include "core/io/project/shot_io.h"
#include "tests/fuzz/fuzz_folder.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace keypose;
  const std::string text(fuzz::Bytes(data, size));
  FrameNumberIn(text);
  return fuzz::Expect([&] { ParseShot(ShotText(ParseShot(text, "shot.json")), "shot.json"); });
}
